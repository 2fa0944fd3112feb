// The trajectory of a swiftlet-plan/1, evaluated from the very coefficients that the planner certified.

export const kAxes = ['x', 'y', 'z'];

/// Value, first, second derivative of sum c_j t^j by Horner's rule.
export function evaluate(coefficients, t) {
  let value = 0;
  let first = 0;
  let half_second = 0;
  for (let j = coefficients.length - 1; j >= 0; --j) {
    half_second = half_second * t + first;
    first = first * t + value;
    value = value * t + coefficients[j];
  }
  return [value, first, 2 * half_second];
}

export function norm(v) {
  return Math.hypot(...v);
}

export class Trajectory {
  constructor(segments) {
    this.segments = segments;
    this.starts = [0];
    for (const segment of segments) this.starts.push(this.starts.at(-1) + segment.duration);
  }

  get duration() {
    return this.starts.at(-1);
  }

  /// Index of the segment in force at time t; a junction belongs to the later one.
  segment_at(t) {
    let low = 0;
    let high = this.segments.length - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.starts[middle] <= t) low = middle;
      else high = middle - 1;
    }
    return low;
  }

  sample(t, index = this.segment_at(t)) {
    const segment = this.segments[index];
    const local = Math.min(Math.max(t - this.starts[index], 0), segment.duration);
    const [x, y, z] = kAxes.map((axis) => evaluate(segment[axis], local));
    return { t, index, position: [x[0], y[0], z[0]], velocity: [x[1], y[1], z[1]], acceleration: [x[2], y[2], z[2]] };
  }

  /// About `wanted` samples over the whole time, the two ends of every segment among them.
  samples(wanted) {
    const result = [];
    this.segments.forEach((segment, index) => {
      const pieces = Math.max(4, Math.round((wanted * segment.duration) / this.duration));
      for (let i = 0; i <= pieces; ++i) {
        result.push(this.sample(this.starts[index] + (segment.duration * i) / pieces, index));
      }
    });
    return result;
  }
}

/// Least distance from `point` to the faces of box [x0,y0,z0,x1,y1,z1]; negative outside.
export function box_margin(box, point) {
  return Math.min(...point.map((value, axis) => Math.min(value - box[axis], box[axis + 3] - value)));
}
