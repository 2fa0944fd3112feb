import { BufferAttribute, BufferGeometry, Group, LineBasicMaterial, LineSegments } from 'three';
import { style_colour } from './colours.js';
import { fixed } from './markup.js';
import { multiples, tick_digits, tick_step } from './ticks.js';

// A floor grid and rulers in metres around box [x0,y0,z0,x1,y1,z1], so that every view has its scale.

function lines(points, opacity) {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(new Float32Array(points.flat()), 3));
  return new LineSegments(geometry, new LineBasicMaterial({ transparent: true, opacity, depthWrite: false }));
}

/// The multiples of `step` in [low, high] and the two ends.
function grid_places(low, high, step) {
  return [low, ...multiples(low, high, step), high];
}

function floor_lines(box, step) {
  const z = box[2];
  const along_y = grid_places(box[0], box[3], step).map((x) => [x, box[1], z, x, box[4], z]);
  const along_x = grid_places(box[1], box[4], step).map((y) => [box[0], y, z, box[3], y, z]);
  return [...along_y, ...along_x];
}

/// Adds the layer 'rulers' with its labels to the view.
export function add_rulers(view, box) {
  const step = tick_step(Math.max(box[3] - box[0], box[4] - box[1]), 8);
  const parts = [
    lines(floor_lines(box, step / 5), 0.2),
    lines(floor_lines(box, step), 0.5),
    lines([[box[0], box[1], box[2], box[0], box[1], box[5]]], 0.8),
  ];
  view.add('rulers', {
    object: new Group().add(...parts),
    recolour: () => parts.forEach((part) => part.material.color.set(style_colour('--ruler'))),
  });
  add_labels(view, box, step);
}

function add_labels(view, [x0, y0, z0, x1, y1, z1], step) {
  const digits = tick_digits(step);
  const away = step * 0.22;
  const put = (text, position, style = '') => view.label(text, position, `ruler ${style}`, 'rulers');
  for (const x of multiples(x0, x1, step)) put(fixed(x, digits), [x, y0 - away, z0]);
  for (const y of multiples(y0, y1, step)) put(fixed(y, digits), [x1 + away, y, z0]);
  put('x [m], east', [(x0 + x1) / 2, y0 - 2.4 * away, z0], 'name');
  put('y [m], north', [x1 + 4.5 * away, (y0 + y1) / 2, z0], 'name');
  put(`z ${fixed(z1, 1)}`, [x0, y0, z1 + away / 2]);
}
