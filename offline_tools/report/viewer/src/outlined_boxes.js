import { BufferAttribute, BufferGeometry, DoubleSide, GreaterDepth, Group, LineBasicMaterial, LineSegments, Mesh, MeshBasicMaterial } from 'three';
import { style_colour } from './colours.js';

// A few translucent boxes with their edges, which shimmer through what hides them. Corners are numbered by bits x=1, y=2, z=4.

const kEdges = [0, 1, 2, 3, 4, 5, 6, 7, 0, 2, 1, 3, 4, 6, 5, 7, 0, 4, 1, 5, 2, 6, 3, 7];
const kFaces = [0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5];

function corner_positions(boxes) {
  const positions = [];
  for (const box of boxes) {
    for (let corner = 0; corner < 8; ++corner) {
      for (let axis = 0; axis < 3; ++axis) positions.push(box[axis + (corner & (1 << axis) ? 3 : 0)]);
    }
  }
  return new BufferAttribute(new Float32Array(positions), 3);
}

function indexed(positions, box_count, corners) {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', positions);
  geometry.setIndex(Array.from({ length: box_count }, (_, i) => corners.map((corner) => 8 * i + corner)).flat());
  return geometry;
}

/// `boxes` are [x0,y0,z0,x1,y1,z1] in metres; `colour` names a colour of the style sheet.
export function outlined_boxes(boxes, { colour, face_opacity, edge_opacity }) {
  const positions = corner_positions(boxes);
  const faces = new MeshBasicMaterial({ transparent: true, opacity: face_opacity, depthWrite: false, side: DoubleSide });
  const edges = new LineBasicMaterial({ transparent: true, opacity: edge_opacity, depthWrite: false });
  const hidden = new LineBasicMaterial({ transparent: true, opacity: edge_opacity / 4, depthFunc: GreaterDepth, depthWrite: false });
  const outline = indexed(positions, boxes.length, kEdges);
  const object = new Group().add(new Mesh(indexed(positions, boxes.length, kFaces), faces), new LineSegments(outline, edges),
                                 new LineSegments(outline, hidden));
  return {
    object,
    recolour: () => [faces, edges, hidden].forEach((material) => material.color.set(style_colour(colour))),
  };
}
