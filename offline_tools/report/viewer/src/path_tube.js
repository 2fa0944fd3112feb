import { BufferAttribute, BufferGeometry, Color, GLSL3, GreaterDepth, Group, Mesh, ShaderMaterial, SphereGeometry, Vector3 } from 'three';
import { speed_colour, style_colour } from './colours.js';
import { norm } from './trajectory.js';

// The path as a tube coloured by speed. Its radius grows with distance, so that it never gets thinner than a few
// pixels; where obstacles hide it, it shimmers through.

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

const kTubeFragment = `
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
  return new ShaderMaterial({ glslVersion: GLSL3, vertexShader: kTubeVertex, fragmentShader: kTubeFragment, uniforms, ...options });
}

/// Frames along the path, each carried over from the last with the least twist.
function ring_directions(points) {
  const along = points.map((point, i) => {
    const ahead = points[Math.min(i + 1, points.length - 1)].clone().sub(points[Math.max(i - 1, 0)]);
    return ahead.lengthSq() > 0 ? ahead.normalize() : new Vector3(1, 0, 0);
  });
  let side = Math.abs(along[0].z) < 0.9 ? new Vector3(0, 0, 1) : new Vector3(1, 0, 0);
  return along.map((direction) => {
    side = side.clone().addScaledVector(direction, -side.dot(direction)).normalize();
    return { side, other: direction.clone().cross(side) };
  });
}

function tube_geometry(samples, top_speed) {
  const points = samples.map((sample) => new Vector3(...sample.position));
  const frames = ring_directions(points);
  const positions = [];
  const normals = [];
  const tints = [];
  const index = [];
  points.forEach((point, i) => {
    const tint = speed_colour(norm(samples[i].velocity) / top_speed);
    for (let k = 0; k < kRing; ++k) {
      const angle = (2 * Math.PI * k) / kRing;
      const normal = frames[i].side.clone().multiplyScalar(Math.cos(angle)).addScaledVector(frames[i].other, Math.sin(angle));
      positions.push(...point.toArray());
      normals.push(...normal.toArray());
      tints.push(...tint);
      if (i === 0) continue;
      const [a, b] = [i * kRing + k, i * kRing + ((k + 1) % kRing)];
      index.push(a - kRing, b - kRing, a, b - kRing, b, a);
    }
  });
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(new Float32Array(positions), 3));
  geometry.setAttribute('normal', new BufferAttribute(new Float32Array(normals), 3));
  geometry.setAttribute('tint', new BufferAttribute(new Float32Array(tints), 3));
  geometry.setIndex(index);
  return geometry;
}

export function path_tube(samples, { radius, top_speed }) {
  const geometry = tube_geometry(samples, top_speed);
  const tube = new Mesh(geometry, tube_material(radius, 1, {}));
  const hidden = new Mesh(geometry, tube_material(radius, 0.5, { transparent: true, depthFunc: GreaterDepth, depthWrite: false }));
  tube.frustumCulled = hidden.frustumCulled = false;
  hidden.renderOrder = 1;
  return { object: new Group().add(tube, hidden) };
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
