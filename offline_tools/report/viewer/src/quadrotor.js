import { BoxGeometry, BufferGeometry, CircleGeometry, Color, ConeGeometry, CylinderGeometry, DoubleSide, Float32BufferAttribute, GLSL3,
         GreaterDepth, Group, Line, LineBasicMaterial, Mesh, ShaderMaterial, TorusGeometry } from 'three';
import { mergeGeometries } from 'three/examples/jsm/utils/BufferGeometryUtils.js';
import { style_colour } from './colours.js';
import { kShadedFragment } from './path_tube.js';

// The vehicle: a frame with four rotors, body axes forward-left-up, its front in another colour. From afar it is drawn
// larger than it is, so that its attitude can be seen; where obstacles hide it, it shimmers through.

const kLeast = 0.013;  // apparent radius, as a share of the distance

// In radii, from the centre to the tips of the propellers.
const kRotor = 0.38;
const kArm = 0.62;
const kRotorHeight = 0.12;

const kVertex = `
uniform vec3 tint;
out vec3 shade;
out vec3 facing;
void main() {
  shade = tint;
  facing = normalMatrix * normal;
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
}`;

function material(tint, opacity, options) {
  return new ShaderMaterial({ glslVersion: GLSL3, vertexShader: kVertex, fragmentShader: kShadedFragment, transparent: true,
                              uniforms: { tint, opacity: { value: opacity } }, ...options });
}

const rotor_places = [1, 3, 5, 7].map((eighth) => [kArm * Math.cos((eighth * Math.PI) / 4), kArm * Math.sin((eighth * Math.PI) / 4), eighth]);

function rim(x, y) {
  return new TorusGeometry(kRotor, 0.022, 8, 40).translate(x, y, kRotorHeight);
}

function body_geometry() {
  const arms = rotor_places.map(([x, y, eighth]) =>
    new BoxGeometry(kArm, 0.07, 0.05).translate(kArm / 2, 0, 0).rotateZ((eighth * Math.PI) / 4));
  const masts = rotor_places.map(([x, y]) => new CylinderGeometry(0.05, 0.06, kRotorHeight + 0.03, 12).rotateX(Math.PI / 2).translate(x, y, kRotorHeight / 2));
  const rims = rotor_places.filter(([x]) => x < 0).map(([x, y]) => rim(x, y));
  return mergeGeometries([new BoxGeometry(0.46, 0.3, 0.15), new BoxGeometry(0.26, 0.2, 0.08).translate(-0.04, 0, 0.11), ...arms, ...masts, ...rims]);
}

function front_geometry() {
  const rims = rotor_places.filter(([x]) => x > 0).map(([x, y]) => rim(x, y));
  const nose = new ConeGeometry(0.11, 0.3, 20).rotateZ(-Math.PI / 2).translate(0.4, 0, 0.01);
  return mergeGeometries([nose, ...rims]);
}

function disc_geometry() {
  return mergeGeometries(rotor_places.map(([x, y]) => new CircleGeometry(kRotor, 36).translate(x, y, kRotorHeight)));
}

function drop_line() {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new Float32BufferAttribute([0, 0, 0, 0, 0, -1], 3));
  const line = new Line(geometry, new LineBasicMaterial({ transparent: true, opacity: 0.7, depthWrite: false }));
  line.frustumCulled = false;
  return line;
}

/// A vehicle of `radius` [m] with a line down to height `floor` [m]. `pose(position, [x, y, z, w])` places it.
export function quadrotor({ radius, floor }) {
  const colours = { '--vehicle': { value: new Color() }, '--front': { value: new Color() } };
  const model = new Group();
  const parts = [[body_geometry(), '--vehicle', 1], [front_geometry(), '--front', 1], [disc_geometry(), '--vehicle', 0.22]];
  for (const [geometry, colour, opacity] of parts) {
    const seen = new Mesh(geometry, material(colours[colour], opacity, { side: DoubleSide, depthWrite: opacity === 1 }));
    const hidden = new Mesh(geometry, material(colours[colour], opacity * 0.3, { depthFunc: GreaterDepth, depthWrite: false }));
    seen.renderOrder = opacity === 1 ? 4 : 5;
    hidden.renderOrder = 3;  // before, so that the vehicle does not shimmer through itself
    model.add(seen, hidden);
  }
  const line = drop_line();
  const object = new Group().add(model, line);
  return {
    object,
    pose(position, attitude) {
      object.position.set(...position);
      model.quaternion.set(...attitude);
      line.scale.z = Math.max(position[2] - floor, 1e-3);
    },
    prepare: (camera) => model.scale.setScalar(Math.max(radius, kLeast * camera.position.distanceTo(object.position))),
    recolour() {
      for (const [name, { value }] of Object.entries(colours)) value.set(style_colour(name));
      line.material.color.set(style_colour('--vehicle'));
    },
  };
}
