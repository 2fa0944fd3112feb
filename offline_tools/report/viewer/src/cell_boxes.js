import { Color, GLSL3, Group, InstancedBufferAttribute, Mesh, ShaderMaterial, Vector2 } from 'three';
import { style_colour } from './colours.js';
import { box_instances } from './solid_boxes.js';

// Many boxes in one draw call, each in its own colour and with its edges drawn, cut by height like the obstacles. Thin
// boxes show as bordered panes.

const kVertex = `
in vec3 box_low;
in vec3 box_high;
in vec3 box_colour;
uniform float unit;
uniform vec2 slice;
out vec3 at;
out vec3 facing;
out vec3 base;
flat out vec3 low;
flat out vec3 high;
void main() {
  low = box_low * unit;
  high = box_high * unit;
  facing = normal;
  base = box_colour;
  if (low.z > slice.y || high.z < slice.x || (low.z < high.z && (low.z >= slice.y || high.z <= slice.x))) {
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
uniform vec3 shade_colour;
uniform float opacity;
in vec3 at;
in vec3 facing;
in vec3 base;
flat in vec3 low;
flat in vec3 high;
out vec4 colour;

float edge() {
  vec3 width = max(fwidth(at), vec3(1e-6));
  vec3 away = min(at - low, high - at) / width + abs(facing) * 1e3;
  vec3 size = (high - low) / width + abs(facing) * 1e3;
  float line = 1.0 - clamp(min(min(away.x, away.y), away.z) - 0.35, 0.0, 1.0);
  return line * clamp(min(min(size.x, size.y), size.z) / 5.0 - 0.4, 0.0, 1.0);
}

void main() {
  float light = 0.62 + 0.38 * dot(facing, normalize(vec3(0.32, -0.5, 0.8)));
  float line = edge();
  vec3 lit = mix(base, shade_colour, clamp((1.0 - light) * 0.6 + line * 0.45, 0.0, 1.0));
  colour = vec4(lit, mix(opacity, 1.0, opacity < 1.0 ? line * 0.8 : 0.0));
}`;

/// `boxes` is as decode_boxes returns it. `colours` are three bytes a box, set anew by `paint`; instead, `colour` names
/// one colour of the style sheet for all. With an opacity below 1 what lies behind shows through.
export function cell_boxes(boxes, { colours, colour, opacity = 1 }) {
  const uniforms = {
    unit: { value: boxes.unit },
    slice: { value: new Vector2(-1e9, 1e9) },
    shade_colour: { value: new Color() },
    opacity: { value: opacity },
  };
  const material = new ShaderMaterial({ glslVersion: GLSL3, vertexShader: kVertex, fragmentShader: kFragment, uniforms,
                                        transparent: opacity < 1, depthWrite: opacity === 1, polygonOffset: opacity < 1,
                                        polygonOffsetFactor: -1, polygonOffsetUnits: -2 });
  const geometry = box_instances(boxes.data);
  const attribute = new InstancedBufferAttribute(colours ?? new Uint8Array(boxes.data.length / 2), 3, true);
  geometry.setAttribute('box_colour', attribute);
  const mesh = new Mesh(geometry, material);
  mesh.frustumCulled = false;
  const object = new Group().add(mesh);
  object.position.set(...boxes.origin);
  return {
    object,
    slice: (low, high) => uniforms.slice.value.set(low - boxes.origin[2], high - boxes.origin[2]),
    paint(fresh) {
      attribute.array.set(fresh);
      attribute.needsUpdate = true;
    },
    recolour() {
      uniforms.shade_colour.value.set(style_colour(colour ? '--ink' : '--solid-shade'));
      if (!colour) return;
      const { r, g, b } = new Color(style_colour(colour));
      for (let i = 0; i < attribute.array.length; ++i) attribute.array[i] = Math.round(255 * [r, g, b][i % 3]);
      attribute.needsUpdate = true;
    },
  };
}
