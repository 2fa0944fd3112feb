/// Boxes as the page carries them: base64 of 16-bit little-endian x0,y0,z0,x1,y1,z1 in units from an origin.
export function decode_boxes({ origin, unit, voxel, boxes }) {
  return { data: decode_integers(boxes), origin, unit, voxel };
}

/// 16-bit little-endian integers from base64.
export function decode_integers(base64) {
  const text = atob(base64);
  const data = new Uint16Array(text.length / 2);
  for (let i = 0; i < data.length; ++i) data[i] = text.charCodeAt(2 * i) | (text.charCodeAt(2 * i + 1) << 8);
  return data;
}

/// Box number i of decoded ones, [x0,y0,z0,x1,y1,z1] in metres.
export function box_at({ data, origin, unit }, i) {
  return Array.from(data.subarray(6 * i, 6 * i + 6), (value, k) => origin[k % 3] + unit * value);
}

/// The box [x0,y0,z0,x1,y1,z1] around boxes of the same form [m]; null around nothing.
export function hull(boxes) {
  if (boxes.length === 0) return null;
  return [0, 1, 2, 3, 4, 5].map((i) => (i < 3 ? Math.min : Math.max)(...boxes.map((box) => box[i])));
}

/// The box around decoded boxes [m]; null around nothing.
export function data_hull({ data, origin, unit }) {
  if (data.length === 0) return null;
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < data.length; i += 6) {
    for (let axis = 0; axis < 3; ++axis) {
      if (data[i + axis] < low[axis]) low[axis] = data[i + axis];
      if (data[i + 3 + axis] > high[axis]) high[axis] = data[i + 3 + axis];
    }
  }
  return [...low, ...high].map((value, i) => origin[i % 3] + unit * value);
}
