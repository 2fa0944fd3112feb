import { ColorManagement, LinearSRGBColorSpace, PerspectiveCamera, Scene, Vector3, WebGLRenderer } from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';

// The 3-D view: frame W with z up, drawn only when something changed. A layer is { object, recolour?, slice?, prepare? }:
// `recolour()` takes the theme's colours anew, `slice(low, high)` cuts it by height [m], `prepare(camera)` comes before
// each picture.

ColorManagement.enabled = false;  // all colours are the display's own, as in the style sheet

const kDirections = { oblique: [-0.18, -0.52, 0.83], top: [0, -0.001, 1], side: [0, -1, 0.12] };

function corners_of(box) {
  return Array.from({ length: 8 }, (_, i) => new Vector3(box[i & 1 ? 3 : 0], box[i & 2 ? 4 : 1], box[i & 4 ? 5 : 2]));
}

export class View {
  /// Throws where the browser has no WebGL 2.
  constructor(host) {
    this.host = host;
    this.renderer = new WebGLRenderer({ antialias: true, alpha: true });
    this.renderer.outputColorSpace = LinearSRGBColorSpace;
    this.renderer.debug.checkShaderErrors = false;  // asking for the logs would stall the first frame
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.scene = new Scene();
    this.camera = new PerspectiveCamera(32, 1, 0.1, 1000);
    this.camera.up.set(0, 0, 1);
    this.layers = new Map();
    this.labels = [];
    host.append(this.renderer.domElement);
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.zoomToCursor = true;
    this.controls.addEventListener('change', () => this.request_frame());
    this.controls.addEventListener('start', () => (this.fitted = null));
    this.#fill_host();
    new ResizeObserver(() => this.#fill_host() && this.#draw()).observe(host);
  }

  add(name, layer) {
    this.layers.set(name, layer);
    this.scene.add(layer.object);
    this.request_frame();
  }

  remove(name) {
    const object = this.layers.get(name)?.object;
    if (object) this.scene.remove(object);
    object?.traverse((part) => [part.geometry, part.material].forEach((resource) => resource?.dispose()));
    this.layers.delete(name);
    this.request_frame();
  }

  show(name, visible) {
    this.layers.get(name).object.visible = visible;
    this.request_frame();
  }

  /// Moves a layer to `position` [m]; null hides it.
  place(name, position) {
    const { object } = this.layers.get(name);
    if (position) object.position.set(...position);
    this.show(name, position !== null);
  }

  /// Moves the camera with a point [m] that stays in the middle; null lets it go.
  follow(position) {
    this.controls.zoomToCursor = this.controls.enablePan = position === null;
    if (position) {
      const target = new Vector3(...position);
      this.camera.position.add(target).sub(this.controls.target);
      this.controls.target.copy(target);
      this.controls.update();
      this.fitted = null;
    }
    this.request_frame();
  }

  /// Puts the camera at `offset` [m] from what it looks at.
  stand_off(offset) {
    this.camera.position.copy(this.controls.target).add(new Vector3(...offset));
    this.controls.update();
    this.request_frame();
  }

  slice(low, high) {
    for (const layer of this.layers.values()) layer.slice?.(low, high);
    this.request_frame();
  }

  recolour() {
    for (const layer of this.layers.values()) layer.recolour?.();
    this.request_frame();
  }

  /// Calls `listener(origin, direction)` with the line of sight [m] of every click that is not a drag.
  on_click(listener) {
    let pressed = null;
    const canvas = this.renderer.domElement;
    canvas.addEventListener('pointerdown', (event) => (pressed = [event.clientX, event.clientY]));
    canvas.addEventListener('pointerup', (event) => {
      if (!pressed || Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) > 4) return;
      const frame = canvas.getBoundingClientRect();
      const place = [((event.clientX - frame.left) / frame.width) * 2 - 1, 1 - ((event.clientY - frame.top) / frame.height) * 2];
      const origin = this.camera.position;
      const direction = new Vector3(...place, 0.5).unproject(this.camera).sub(origin).normalize();
      listener(origin.toArray(), direction.toArray());
    });
  }

  /// A caption that stays at `position` [m] in front of everything; hidden with its layer.
  label(text, position, style, layer) {
    const element = document.createElement('span');
    element.className = `label ${style}`;
    element.textContent = text;
    this.host.append(element);
    this.labels.push({ element, position: new Vector3(...position), layer });
  }

  /// Looks at box [x0,y0,z0,x1,y1,z1] from a named direction, from as near as shows all of it.
  fit(box, direction) {
    this.fitted = { box, direction };
    const corners = corners_of(box);
    const toward = new Vector3(...kDirections[direction]).normalize();
    const right = new Vector3(0, 0, 1).cross(toward).normalize();
    const up = toward.clone().cross(right);
    const size = corners[0].distanceTo(corners[7]);
    const target = corners[0].clone().add(corners[7]).multiplyScalar(0.5);
    let distance = 2 * size;
    for (let round = 0; round < 8; ++round) {
      const seen = this.#seen(corners, target, distance, { toward, right, up });
      target.addScaledVector(right, seen.offset[0]).addScaledVector(up, seen.offset[1]);
      distance *= seen.fill;
    }
    this.camera.position.copy(target).addScaledVector(toward, distance);
    this.#set_depth_range(size, distance);
    this.controls.target.copy(target);
    this.controls.update();
    this.request_frame();
  }

  /// How the corners lie on the screen from `distance`: their middle's offset [m] at the target, and the larger of the
  /// shares of width and height that they take (with a rim left free).
  #seen(corners, target, distance, { toward, right, up }) {
    const tangent = Math.tan((this.camera.fov * Math.PI) / 360);
    const spread = [[right, tangent * this.camera.aspect, 0.92], [up, tangent, 0.86]].map(([axis, half, share]) => {
      const places = corners.map((corner) => {
        const p = corner.clone().sub(target);
        return p.dot(axis) / (half * Math.max(distance - p.dot(toward), distance / 20));
      });
      const [low, high] = [Math.min(...places), Math.max(...places)];
      return { offset: ((low + high) / 2) * half * distance, fill: (high - low) / 2 / share };
    });
    return { offset: spread.map((part) => part.offset), fill: Math.max(...spread.map((part) => part.fill)) };
  }

  #set_depth_range(size, distance) {
    this.camera.near = Math.max(size, distance) / 2000;
    this.camera.far = (size + distance) * 6;
    this.controls.maxDistance = (size + distance) * 2;
    this.camera.updateProjectionMatrix();
  }

  /// Takes the size of the host; false when that is nothing new.
  #fill_host() {
    const { clientWidth: width, clientHeight: height } = this.host;
    if (width === 0 || height === 0 || (width === this.width && height === this.height)) return false;
    this.width = width;
    this.height = height;
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    if (this.fitted) this.fit(this.fitted.box, this.fitted.direction);
    return true;
  }

  request_frame() {
    if (this.pending) return;
    this.pending = true;
    requestAnimationFrame(() => this.pending && this.#draw());
  }

  #draw() {
    this.pending = false;
    for (const layer of this.layers.values()) layer.prepare?.(this.camera);
    this.renderer.render(this.scene, this.camera);
    for (const label of this.labels) this.#place_label(label);
  }

  #place_label({ element, position, layer }) {
    const p = position.clone().project(this.camera);
    const visible = p.z < 1 && (this.layers.get(layer)?.object.visible ?? true);
    element.style.display = visible ? '' : 'none';
    const [x, y] = [((p.x + 1) / 2) * this.width, ((1 - p.y) / 2) * this.height];
    element.style.transform = `translate(${x}px, ${y}px) translate(-50%, -50%)`;
  }
}
