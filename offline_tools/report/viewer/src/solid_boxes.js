import { BoxGeometry, Color, Data3DTexture, GLSL3, Group, InstancedBufferGeometry, InstancedInterleavedBuffer,
         InterleavedBufferAttribute, LinearFilter, LinearMipmapLinearFilter, Mesh, RedFormat, ShaderMaterial, Vector2,
         Vector3 } from 'three';
import { style_colour } from './colours.js';
import { density_grid } from './density.js';

// Hundreds of thousands of solid boxes in one draw call, cut by height in the vertex shader (so that a cut shows a
// section, not a hollow), shaded by how much of their surroundings is filled.

const kVertex = `
in vec3 box_low;
in vec3 box_high;
uniform float unit;
uniform vec2 slice;
out vec3 at;
out vec3 facing;
out float cut;
void main() {
  vec3 low = box_low * unit;
  vec3 high = box_high * unit;
  facing = normal;
  cut = (normal.z > 0.5 && high.z > slice.y) || (normal.z < -0.5 && low.z < slice.x) ? 1.0 : 0.0;
  if (low.z >= slice.y || high.z <= slice.x) {
    gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
    return;
  }
  low.z = max(low.z, slice.x);
  high.z = min(high.z, slice.y);
  at = mix(low, high, position + 0.5);
  gl_Position = projectionMatrix * modelViewMatrix * vec4(at, 1.0);
}`;

const kFragment = `
precision highp float;
precision highp sampler3D;
uniform sampler3D density;
uniform vec3 density_low;
uniform vec3 density_size;
uniform float density_cell;
uniform float voxel;
uniform vec2 slice;
uniform vec3 low_colour;
uniform vec3 high_colour;
uniform vec3 shade_colour;
uniform vec3 cut_colour;
uniform vec2 heights;
in vec3 at;
in vec3 facing;
in float cut;
out vec4 colour;

float filled(vec3 p, float level) {
  float open = step(p.z, slice.y) * step(slice.x, p.z);
  return open * textureLod(density, (p - density_low) / density_size, level).r;
}

float occlusion() {
  vec3 n = facing;
  float near = filled(at + n * density_cell * 1.0, 0.0);
  float middle = filled(at + n * density_cell * 2.5, 1.0);
  float far = filled(at + n * density_cell * 5.5, 2.0);
  return clamp(0.45 * near + 0.5 * middle + 0.4 * far, 0.0, 0.8);
}

float voxel_edge() {
  vec3 p = at / voxel;
  vec3 width = fwidth(p);
  vec3 away = abs(fract(p - 0.5) - 0.5) / max(width, vec3(1e-6));
  away += abs(facing) * 1e3;
  float line = 1.0 - min(min(min(away.x, away.y), away.z), 1.0);
  float fineness = max(max(width.x, width.y), width.z);
  return line * clamp(1.0 - fineness * 4.0, 0.0, 1.0);
}

void main() {
  float light = 0.62 + 0.38 * dot(facing, normalize(vec3(0.32, -0.5, 0.8)));
  float height = clamp((at.z - heights.x) / (heights.y - heights.x), 0.0, 1.0);
  vec3 base = mix(low_colour, high_colour, height);
  float dark = clamp((1.0 - light) * 0.75 + occlusion() * 0.95 + voxel_edge() * 0.16, 0.0, 1.0);
  vec3 lit = mix(base, shade_colour, dark);
  colour = vec4(mix(lit, cut_colour, cut), 1.0);
}`;

/// `boxes` is { data: Uint16Array of x0,y0,z0,x1,y1,z1 each, origin [m], unit [m],
/// voxel: edge of one [m] }.
export function solid_boxes(boxes) {
  const texture = density_texture(boxes);
  const heights = height_range(boxes);
  const uniforms = {
    unit: { value: boxes.unit },
    voxel: { value: boxes.voxel },
    slice: { value: new Vector2(-1e9, 1e9) },
    heights: { value: new Vector2(...heights) },
    density: { value: texture.map },
    density_low: { value: texture.low },
    density_size: { value: texture.size },
    density_cell: { value: texture.cell },
    low_colour: { value: new Color() },
    high_colour: { value: new Color() },
    shade_colour: { value: new Color() },
    cut_colour: { value: new Color() },
  };
  const material = new ShaderMaterial({ glslVersion: GLSL3, vertexShader: kVertex, fragmentShader: kFragment, uniforms });
  const mesh = new Mesh(box_instances(boxes.data), material);
  mesh.frustumCulled = false;
  const object = new Group().add(mesh);
  object.position.set(...boxes.origin);
  return {
    object,
    slice: (low, high) => uniforms.slice.value.set(low - boxes.origin[2], high - boxes.origin[2]),
    recolour() {
      uniforms.low_colour.value.set(style_colour('--solid-low'));
      uniforms.high_colour.value.set(style_colour('--solid-high'));
      uniforms.shade_colour.value.set(style_colour('--solid-shade'));
      uniforms.cut_colour.value.set(style_colour('--solid-cut'));
    },
  };
}

function height_range({ data, unit }) {
  let low = Infinity;
  let high = -Infinity;
  for (let i = 0; i < data.length; i += 6) {
    low = Math.min(low, data[i + 2]);
    high = Math.max(high, data[i + 5]);
  }
  return [low * unit, Math.max(high, low + 1) * unit];
}

/// One cube a box, with its corners as the attributes `box_low` and `box_high` [units].
export function box_instances(data) {
  const cube = new BoxGeometry(1, 1, 1);
  const geometry = new InstancedBufferGeometry();
  geometry.index = cube.index;
  geometry.setAttribute('position', cube.attributes.position);
  geometry.setAttribute('normal', cube.attributes.normal);
  const corners = new InstancedInterleavedBuffer(data, 6);
  geometry.setAttribute('box_low', new InterleavedBufferAttribute(corners, 3, 0));
  geometry.setAttribute('box_high', new InterleavedBufferAttribute(corners, 3, 3));
  geometry.instanceCount = data.length / 6;
  return geometry;
}

function density_texture(boxes) {
  const { values, low, counts, cell } = density_grid(boxes.data, Math.max(1, Math.round(boxes.voxel / boxes.unit)));
  const map = new Data3DTexture(values, ...counts);
  map.format = RedFormat;
  map.unpackAlignment = 1;
  map.magFilter = LinearFilter;
  map.minFilter = LinearMipmapLinearFilter;
  map.generateMipmaps = true;
  map.needsUpdate = true;
  return {
    map,
    cell: cell * boxes.unit,
    low: new Vector3(...low).multiplyScalar(boxes.unit),
    size: new Vector3(...counts).multiplyScalar(cell * boxes.unit),
  };
}
