// How much of space is filled, on a grid coarse enough for a 3-D texture.

const kMostTexels = 6e6;
const kMostTexelsAxis = 256;  // every WebGL 2 has this much

/// Share filled, 0 to 255, of the cells of a grid around all boxes (x0,y0,z0,x1,y1,z1 in units, disjoint). A cell is
/// as few voxels wide as a texture's limits allow; `voxel` is in units.
export function density_grid(data, voxel) {
  const { low, high } = bounds_of(data);
  const counts_for = (width) => low.map((value, axis) => Math.floor((high[axis] - value) / width) + 1);
  let cell = voxel;
  while (!fits(counts_for(cell))) cell += voxel;
  const counts = counts_for(cell);
  const values = new Uint8Array(counts[0] * counts[1] * counts[2]);
  const scale = 255 / cell ** 3;
  for (let i = 0; i < data.length; i += 6) add_box(values, counts, data, i, low, cell, scale);
  return { values, low, counts, cell };
}

function fits(counts) {
  return Math.max(...counts) <= kMostTexelsAxis && counts[0] * counts[1] * counts[2] <= kMostTexels;
}

function bounds_of(data) {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < data.length; ++i) {
    const axis = i % 3;
    if (i % 6 < 3) low[axis] = Math.min(low[axis], data[i]);
    else high[axis] = Math.max(high[axis], data[i]);
  }
  return { low, high };
}

/// Length of [a, b] inside cell number `index` of width `cell`.
function overlap(a, b, index, cell) {
  return Math.min(b, (index + 1) * cell) - Math.max(a, index * cell);
}

function add_box(values, counts, data, i, low, cell, scale) {
  const a = [0, 1, 2].map((axis) => data[i + axis] - low[axis]);
  const b = [0, 1, 2].map((axis) => data[i + 3 + axis] - low[axis]);
  for (let z = Math.floor(a[2] / cell); z * cell < b[2]; ++z) {
    const depth = overlap(a[2], b[2], z, cell) * scale;
    for (let y = Math.floor(a[1] / cell); y * cell < b[1]; ++y) {
      const area = overlap(a[1], b[1], y, cell) * depth;
      const row = (z * counts[1] + y) * counts[0];
      for (let x = Math.floor(a[0] / cell); x * cell < b[0]; ++x) {
        values[row + x] = Math.min(255, values[row + x] + Math.ceil(overlap(a[0], b[0], x, cell) * area));
      }
    }
  }
}
