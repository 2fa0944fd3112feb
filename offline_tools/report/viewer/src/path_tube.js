import { BufferAttribute, BufferGeometry, Color, GLSL3, GreaterDepth, Group, LessDepth, Mesh, ShaderMaterial, SphereGeometry, Vector3 } from 'three';
import { style_colour } from './colours.js';

// A path as a tube. Its radius grows with distance, so that it never gets thinner than a few pixels; where obstacles
// hide it, it shimmers through.

const kRing = 10;

const kTubeVertex = `
in vec3 tint;
uniform float radius;
uniform float least;
out vec3 shade;
out vec3 facing;
void main() {
  vec4 centre = modelViewMatrix * vec4(position, 1.0);
  float size = max(radius, -centre.z * least);
  shade = tint;
  facing = normalMatrix * normal;
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position + normal * size, 1.0);
}`;

export const kShadedFragment = `
precision highp float;
uniform float opacity;
in vec3 shade;
in vec3 facing;
out vec4 colour;
void main() {
  vec3 n = normalize(facing);
  float light = 0.84 + 0.16 * dot(n, normalize(vec3(0.3, 0.8, 0.6)));
  colour = vec4(shade * light, opacity);
}`;

function tube_material(radius, opacity, options) {
  const uniforms = { radius: { value: radius }, least: { value: 0.0021 }, opacity: { value: opacity } };
  return new ShaderMaterial({ glslVersion: GLSL3, vertexShader: kTubeVertex, fragmentShader: kShadedFragment, uniforms, ...options });
}

/// Frames along the path, each carried over from the last with the least twist.
function ring_directions(points) {
  const along = points.map((point, i) => {
    const ahead = points[Math.min(i + 1, points.length - 1)].clone().sub(points[Math.max(i - 1, 0)]);
    return ahead.lengthSq() > 0 ? ahead.normalize() : new Vector3(1, 0, 0);
  });
  let side = Math.abs(along[0]?.z ?? 0) < 0.9 ? new Vector3(0, 0, 1) : new Vector3(1, 0, 0);
  return along.map((direction) => {
    side = side.clone().addScaledVector(direction, -side.dot(direction)).normalize();
    return { side, other: direction.clone().cross(side) };
  });
}

/// Attributes and index of a tube around points; its tints are those of `tint(i)`.
function tube_parts(points, tint) {
  const frames = ring_directions(points);
  const positions = new Float32Array(3 * kRing * points.length);
  const normals = new Float32Array(positions.length);
  const tints = new Float32Array(positions.length);
  const index = [];
  points.forEach((point, i) => {
    for (let k = 0; k < kRing; ++k) {
      const angle = (2 * Math.PI * k) / kRing;
      const normal = frames[i].side.clone().multiplyScalar(Math.cos(angle)).addScaledVector(frames[i].other, Math.sin(angle));
      const at = 3 * (i * kRing + k);
      positions.set(point.toArray(), at);
      normals.set(normal.toArray(), at);
      tints.set(tint(i), at);
      if (i === 0) continue;
      const [a, b] = [i * kRing + k, i * kRing + ((k + 1) % kRing)];
      index.push(a - kRing, b - kRing, a, b - kRing, b, a);
    }
  });
  return { attributes: Object.entries({ position: positions, normal: normals, tint: tints }).map(([name, data]) => [name, new BufferAttribute(data, 3)]), index };
}

function geometry_of({ attributes, index }) {
  const geometry = new BufferGeometry();
  for (const [name, attribute] of attributes) geometry.setAttribute(name, attribute);
  geometry.setIndex(index);
  return geometry;
}

/// A tube along `positions` [m] in the colours that `tint(i)` gives them ([r, g, b]) or in one of the style sheet.
/// `behind` is the opacity where it is hidden. `reach(count)` draws it along the first of the positions only; with `ahead` the rest stays as a shade.
export function path_tube(positions, { radius, tint, colour, behind = 0.5, ahead = false }) {
  const parts = tube_parts(positions.map((position) => new Vector3(...position)), tint ?? (() => [0, 0, 0]));
  const geometry = geometry_of(parts);
  const tube = new Mesh(geometry, tube_material(radius, 1, {}));
  const hidden = new Mesh(geometry, tube_material(radius, behind, { transparent: true, depthFunc: GreaterDepth, depthWrite: false }));
  const meshes = [tube, hidden];
  // What is drawn already covers its own shade: that is at the same depth, not at a lesser one.
  if (ahead) meshes.push(new Mesh(geometry_of(parts), tube_material(radius, 0.22, { transparent: true, depthFunc: LessDepth, depthWrite: false })));
  for (const mesh of meshes) mesh.frustumCulled = false;
  hidden.renderOrder = 1;
  return {
    object: new Group().add(...meshes),
    reach: (count) => geometry.setDrawRange(0, Math.max(count - 1, 0) * kRing * 6),
    recolour() {
      if (!colour) return;
      const [, , [, tints]] = parts.attributes;
      const { r, g, b } = new Color(style_colour(colour));
      for (let i = 0; i < tints.array.length; i += 3) tints.array.set([r, g, b], i);
      tints.needsUpdate = true;
    },
  };
}

const kBallVertex = `
uniform float radius;
uniform float least;
out vec3 facing;
void main() {
  vec4 centre = modelViewMatrix * vec4(0.0, 0.0, 0.0, 1.0);
  facing = normalMatrix * normal;
  gl_Position = projectionMatrix * modelViewMatrix * vec4(normal * max(radius, -centre.z * least), 1.0);
}`;

const kBallFragment = `
precision highp float;
uniform vec3 tint;
uniform float opacity;
in vec3 facing;
out vec4 colour;
void main() {
  vec3 n = normalize(facing);
  float rim = 1.0 - abs(n.z);
  colour = vec4(tint * (0.9 + 0.1 * n.y), mix(opacity, min(1.0, opacity + 0.5), rim * rim));
}`;

/// A ball of `radius` [m] at `position`, at least `least` of its distance in size, in a colour of the style sheet.
export function ball(position, { radius, least, colour, opacity }) {
  const uniforms = { radius: { value: radius }, least: { value: least }, tint: { value: new Color() }, opacity: { value: opacity } };
  const material = new ShaderMaterial({ glslVersion: GLSL3, vertexShader: kBallVertex, fragmentShader: kBallFragment, uniforms,
                                        transparent: true, depthWrite: false });
  const object = new Mesh(new SphereGeometry(1, 32, 20), material);
  object.frustumCulled = false;
  object.renderOrder = 2;
  object.position.set(...position);
  return { object, recolour: () => uniforms.tint.value.set(style_colour(colour)) };
}
