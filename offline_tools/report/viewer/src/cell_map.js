import { box_at, decode_boxes, decode_integers } from './boxes_data.js';
import { kComponentColours, kOtherComponents, speed_colour } from './colours.js';

// The cells of a map report as the page uses them: found by place, by line of sight, by neighbourhood, and coloured.

const bytes_of = (hex) => [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16));

export class CellMap {
  constructor({ grid, cells, components }) {
    this.cells = decode_boxes({ ...grid, boxes: cells.boxes });
    this.extents = decode_boxes({ ...grid, boxes: cells.extents });
    this.labels = decode_integers(cells.components);
    this.ranks = new Map(components.map((component, rank) => [component.label, rank]));
    this.count = this.labels.length;
    this.volumes = Float64Array.from({ length: this.count }, (_, i) => this.#volume(i));
    this.volume_range = this.#volume_range();
  }

  #volume(i) {
    const box = this.box(i);
    return (box[3] - box[0]) * (box[4] - box[1]) * (box[5] - box[2]);
  }

  #volume_range() {
    let range = [Infinity, 0];
    for (const volume of this.volumes) range = [Math.min(range[0], volume), Math.max(range[1], volume)];
    return range;
  }

  box(i) {
    return box_at(this.cells, i);
  }

  extent(i) {
    return box_at(this.extents, i);
  }

  /// Three bytes a cell, by 'volume' (logarithmic, from the smallest to the largest) or by 'component'.
  colours(by) {
    const colours = new Uint8Array(3 * this.count);
    const palette = kComponentColours.map(bytes_of);
    const [least, most] = this.volume_range.map(Math.log);
    for (let i = 0; i < this.count; ++i) {
      const colour = by === 'component' ? palette[this.ranks.get(this.labels[i])] ?? bytes_of(kOtherComponents)
          : speed_colour((Math.log(this.volumes[i]) - least) / Math.max(most - least, 1e-9)).map((channel) => 255 * channel);
      colours.set(colour.map(Math.round), 3 * i);
    }
    return colours;
  }

  /// The cell that holds a point [m], -1 for none.
  at(point) {
    const p = point.map((value, axis) => (value - this.cells.origin[axis]) / this.cells.unit);
    return boxes_across(this.cells, p[2], p[2]).find((i) => [0, 1].every((axis) =>
        this.cells.data[6 * i + axis] <= p[axis] && p[axis] <= this.cells.data[6 * i + axis + 3])) ?? -1;
  }

  /// The windows [m] of a cell to the cells at hand: common boxes that are wide along two axes at least.
  windows(i) {
    const own = this.cells.data.subarray(6 * i, 6 * i + 6);
    const found = [];
    for (let other = 0; other < this.count; ++other) {
      const common = other === i ? null : passage(own, this.cells.data, 6 * other);
      if (common) found.push(common.map((value, k) => this.cells.origin[k % 3] + this.cells.unit * value));
    }
    return found;
  }
}

function passage(own, data, at) {
  const common = [0, 1, 2, 3, 4, 5].map((k) => (k < 3 ? Math.max : Math.min)(own[k], data[at + k]));
  const widths = [0, 1, 2].map((axis) => common[axis + 3] - common[axis]);
  return Math.min(...widths) >= 0 && widths.filter((width) => width > 0).length >= 2 ? common : null;
}

/// Numbers of the decoded boxes that reach over the whole of [low, high] in height [units].
export function boxes_across({ data }, low, high) {
  const found = [];
  for (let i = 0; 6 * i < data.length; ++i) {
    if (data[6 * i + 2] <= low && data[6 * i + 5] >= high) found.push(i);
  }
  return found;
}

/// The box first met by a line of sight [m] among those between two heights [m]: { index, distance [m] } or null.
export function first_hit(boxes, origin, direction, [lowest, highest]) {
  const { data, unit } = boxes;
  const from = origin.map((value, axis) => (value - boxes.origin[axis]) / unit);
  const band = [lowest, highest].map((z) => (z - boxes.origin[2]) / unit);
  let best = null;
  for (let at = 0; at < data.length; at += 6) {
    const low = Math.max(data[at + 2], band[0]);
    const high = Math.min(data[at + 5], band[1]);
    if (low >= high) continue;
    let enter = 0;
    let leave = best?.distance ?? Infinity;
    for (let axis = 0; axis < 3 && enter < leave; ++axis) {
      const a = ((axis === 2 ? low : data[at + axis]) - from[axis]) / direction[axis];
      const b = ((axis === 2 ? high : data[at + 3 + axis]) - from[axis]) / direction[axis];
      enter = Math.max(enter, Math.min(a, b));
      leave = Math.min(leave, Math.max(a, b));
    }
    if (enter < leave) best = { index: at / 6, distance: enter };
  }
  return best && { index: best.index, distance: best.distance * unit };
}

/// The height [m] at which a level cut through the cells is largest, midway between the cells' faces around it.
export function widest_height({ data, origin, unit }) {
  const changes = new Map();
  for (let at = 0; at < data.length; at += 6) {
    const area = (data[at + 3] - data[at]) * (data[at + 4] - data[at + 1]);
    changes.set(data[at + 2], (changes.get(data[at + 2]) ?? 0) + area);
    changes.set(data[at + 5], (changes.get(data[at + 5]) ?? 0) - area);
  }
  const faces = [...changes.keys()].sort((a, b) => a - b);
  let [area, best, height] = [0, 0, 0];
  faces.forEach((z, i) => {
    area += changes.get(z);
    if (area > best) [best, height] = [area, (z + (faces[i + 1] ?? z)) / 2];
  });
  return origin[2] + unit * height;
}
