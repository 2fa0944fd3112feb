import { decode_integers } from './boxes_data.js';

// The motion of a flight as its page carries it, looked up by time.

const kNone = 65535;

/// Values of a packed channel; NaN for those that do not exist.
export function decode_channel({ low, step, values }) {
  return Float64Array.from(decode_integers(values), (integer) => (integer === kNone ? NaN : low + step * integer));
}

/// Index of the last of ascending `times` that is at or before t; -1 before the first.
export function last_at(times, t) {
  let [low, high] = [-1, times.length - 1];
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (times[middle] <= t) low = middle;
    else high = middle - 1;
  }
  return low;
}

/// The parts of a flight that a list of changes { t, ... } makes, each with its end.
export function spans(changes, duration) {
  return changes.map((change, i) => ({ ...change, end: changes[i + 1]?.t ?? duration }));
}

export class FlightTrack {
  constructor({ t, shown, count, ...channels }) {
    const high = decode_integers(t.high);
    this.t = Float64Array.from(decode_integers(t.low), (low, i) => (65536 * high[i] + low) / 1000);
    for (const [name, channel] of Object.entries(channels)) this[name] = decode_channel(channel);
    const { qw, qx, qy, qz } = this;
    this.tilt = this.t.map((_, i) => degrees(Math.acos(Math.min(Math.max(1 - 2 * (qx[i] ** 2 + qy[i] ** 2), -1), 1))));
    this.heading = this.t.map((_, i) => degrees(Math.atan2(2 * (qw[i] * qz[i] + qx[i] * qy[i]), 1 - 2 * (qy[i] ** 2 + qz[i] ** 2))));
  }

  get duration() {
    return this.t.at(-1) ?? 0;
  }

  /// The sample in force at time t and how far it is on the way to the next one, 0 to 1.
  #place(t) {
    const i = Math.max(last_at(this.t, t), 0);
    const width = this.t[i + 1] - this.t[i];
    return [i, width > 0 ? Math.min(Math.max((t - this.t[i]) / width, 0), 1) : 0];
  }

  /// A channel at time t, as the sample in force has it.
  value(name, t) {
    return this[name][this.#place(t)[0]];
  }

  #between(names, t) {
    const [i, share] = this.#place(t);
    return names.map((name) => this[name][i] + (share > 0 ? share * (this[name][i + 1] - this[name][i]) : 0));
  }

  /// [m]
  position(t) {
    return this.#between(['x', 'y', 'z'], t);
  }

  /// [m]; null without one.
  reference(t) {
    const point = this.#between(['reference_x', 'reference_y', 'reference_z'], t);
    return point.every(Number.isFinite) ? point : null;
  }

  /// Unit quaternion [x, y, z, w], the near way round between samples.
  attitude(t) {
    const [i, share] = this.#place(t);
    const [a, b] = [i, Math.min(i + 1, this.t.length - 1)].map((k) => [this.qx[k], this.qy[k], this.qz[k], this.qw[k]]);
    const sign = a.reduce((sum, value, k) => sum + value * b[k], 0) < 0 ? -1 : 1;
    const mixed = a.map((value, k) => (1 - share) * value + share * sign * b[k]);
    const size = Math.hypot(...mixed);
    return mixed.map((value) => value / size);
  }

  /// Indices of samples about `spacing` [m] apart along the way, the first and the last among them.
  path(spacing) {
    const kept = [];
    let [x, y, z] = [Infinity, 0, 0];
    for (let i = 0; i < this.t.length; ++i) {
      if (i < this.t.length - 1 && Math.hypot(this.x[i] - x, this.y[i] - y, this.z[i] - z) < spacing) continue;
      kept.push(i);
      [x, y, z] = [this.x[i], this.y[i], this.z[i]];
    }
    return kept;
  }

  /// Way flown [m].
  get length() {
    let sum = 0;
    for (let i = 1; i < this.t.length; ++i) {
      sum += Math.hypot(this.x[i] - this.x[i - 1], this.y[i] - this.y[i - 1], this.z[i] - this.z[i - 1]);
    }
    return sum;
  }

  /// A channel as [t, value] with at most about `most` points: the extremes of every stretch, and one NaN for a gap.
  curve(name, most) {
    const values = this[name];
    const stretch = Math.max(1, Math.ceil((2 * values.length) / most));
    const line = [];
    for (let begin = 0; begin < values.length; begin += stretch) {
      for (const i of stretch_extremes(values, begin, Math.min(begin + stretch, values.length))) line.push([this.t[i], values[i]]);
    }
    return line;
  }
}

const degrees = (radians) => (180 / Math.PI) * radians;

/// Indices of the least and the largest value in [begin, end), in their order; of one that is missing where none exists.
function stretch_extremes(values, begin, end) {
  let [least, most] = [-1, -1];
  for (let i = begin; i < end; ++i) {
    if (Number.isNaN(values[i])) continue;
    if (least < 0 || values[i] < values[least]) least = i;
    if (most < 0 || values[i] > values[most]) most = i;
  }
  if (least < 0) return [begin];
  return least === most ? [least] : [Math.min(least, most), Math.max(least, most)];
}
