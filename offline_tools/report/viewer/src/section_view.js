import { boxes_across } from './cell_map.js';
import { style_colour } from './colours.js';
import { fixed } from './markup.js';
import { multiples, tick_digits, tick_step } from './ticks.js';

// A level cut through a map, seen from above, on a plain canvas: it needs no WebGL.

const kMargin = { left: 44, right: 12, top: 12, bottom: 26 };
const kTallest = 640;

export class SectionView {
  /// Draws into `host`; `bounds` is [x0,y0,z0,x1,y1,z1] in metres. `on_point([x, y, z], clicked)` follows the pointer.
  constructor(host, bounds, { map, obstacles, on_point }) {
    Object.assign(this, { host, bounds, map, obstacles, height: bounds[2], selected: -1 });
    this.canvas = document.createElement('canvas');
    this.context = this.canvas.getContext('2d');
    host.append(this.canvas);
    const report = (event) => on_point([...this.#to_world(event.offsetX, event.offsetY), this.height], event.type === 'click');
    this.canvas.addEventListener('pointermove', report);
    this.canvas.addEventListener('click', report);
    this.canvas.addEventListener('pointerleave', () => on_point(null, false));
    new ResizeObserver(() => this.draw()).observe(host);
  }

  /// Any of height [m], colours (three bytes a cell) and selected (a cell, -1 for none).
  set(state) {
    Object.assign(this, state);
    this.draw();
  }

  #fill_host() {
    const width = this.host.clientWidth;
    const [x0, y0, , x1, y1] = this.bounds;
    const room = [width - kMargin.left - kMargin.right, kTallest - kMargin.top - kMargin.bottom];
    this.scale = Math.min(room[0] / (x1 - x0), room[1] / (y1 - y0));
    const height = Math.round((y1 - y0) * this.scale) + kMargin.top + kMargin.bottom;
    const density = Math.min(window.devicePixelRatio || 1, 2);
    Object.assign(this.canvas, { width: width * density, height: height * density });
    Object.assign(this.canvas.style, { width: `${width}px`, height: `${height}px` });
    this.context.setTransform(density, 0, 0, density, 0, 0);
    this.left = kMargin.left + (room[0] - (x1 - x0) * this.scale) / 2;
    this.bottom = height - kMargin.bottom;
  }

  #x(x) {
    return this.left + (x - this.bounds[0]) * this.scale;
  }

  #y(y) {
    return this.bottom - (y - this.bounds[1]) * this.scale;
  }

  #to_world(x, y) {
    return [this.bounds[0] + (x - this.left) / this.scale, this.bounds[1] + (this.bottom - y) / this.scale];
  }

  #rectangle([x0, y0, , x1, y1]) {
    return [this.#x(x0), this.#y(y1), (x1 - x0) * this.scale, (y1 - y0) * this.scale];
  }

  /// The rectangles [pixels] of the decoded boxes at the present height, with their numbers.
  #cut(boxes) {
    const { data, origin, unit } = boxes;
    const z = (this.height - origin[2]) / unit;
    return boxes_across(boxes, z, z).map((i) => {
      const box = [0, 1, 2, 3, 4, 5].map((k) => origin[k % 3] + unit * data[6 * i + k]);
      return { i, rectangle: this.#rectangle(box) };
    });
  }

  draw() {
    if (this.host.clientWidth < 80 || !this.colours) return;
    this.#fill_host();
    this.#draw_cells();
    this.#draw_obstacles();
    this.#draw_axes();
    if (this.selected >= 0) this.#draw_selected();
  }

  #draw_cells() {
    const { context, colours } = this;
    context.strokeStyle = style_colour('--section-edge');
    context.lineWidth = 0.6;
    for (const { i, rectangle } of this.#cut(this.map.cells)) {
      context.fillStyle = `rgb(${colours[3 * i]} ${colours[3 * i + 1]} ${colours[3 * i + 2]})`;
      context.fillRect(...rectangle);
      if (Math.min(rectangle[2], rectangle[3]) > 3) context.strokeRect(...rectangle);
    }
  }

  #draw_obstacles() {
    if (!this.obstacles) return;
    this.context.fillStyle = style_colour('--section-solid');
    for (const { rectangle } of this.#cut(this.obstacles)) this.context.fillRect(...rectangle);
  }

  #draw_axes() {
    const { context } = this;
    const [x0, y0, , x1, y1] = this.bounds;
    const step = tick_step(Math.max(x1 - x0, y1 - y0), 10);
    const digits = tick_digits(step);
    context.fillStyle = context.strokeStyle = style_colour('--soft');
    context.font = `11px ${getComputedStyle(this.host).fontFamily}`;
    context.textAlign = 'center';
    for (const x of multiples(x0, x1, step)) context.fillText(fixed(x, digits), this.#x(x), this.bottom + 16);
    context.textAlign = 'right';
    for (const y of multiples(y0, y1, step)) context.fillText(fixed(y, digits), this.left - 6, this.#y(y) + 4);
    context.lineWidth = 0.5;
    context.strokeRect(...this.#rectangle(this.bounds));
  }

  #draw_selected() {
    const { context } = this;
    const outline = (box, colour, width, dash) => {
      context.strokeStyle = style_colour(colour);
      context.lineWidth = width;
      context.setLineDash(dash);
      context.strokeRect(...this.#rectangle(box));
      context.setLineDash([]);
    };
    outline(this.map.extent(this.selected), '--ink', 1.5, [6, 4]);
    outline(this.map.box(this.selected), '--ink', 2.5, []);
  }
}
