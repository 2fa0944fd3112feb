import { speed_stops } from './colours.js';
import { escape_html, fixed } from './markup.js';
import { tick_digits, tick_step, ticks } from './ticks.js';

// Small multiples over time with one cursor. A panel is
//   { title, unit, line: [[t, value], ...], colour: class name or 'speed',
//     limits: [number], band: [[t0, t1, low, high], ...], at: (t) => value, note: (t) => text }

const kLeft = 44;
const kRight = 8;
const kTop = 8;
const kBottom = 20;

/// The value range of a panel: everything drawn but the band, which is cut where it is far wider than the line.
export function value_range(panel) {
  let low = Infinity;
  let high = -Infinity;
  const include = (value) => {
    low = Math.min(low, value);
    high = Math.max(high, value);
  };
  for (const [, value] of panel.line) include(value);
  for (const limit of panel.limits ?? []) include(limit);
  const reach = Math.max(high - low, 0.5);
  for (const [, , band_low, band_high] of panel.band ?? []) {
    include(Math.max(band_low, low - reach / 4));
    include(Math.min(band_high, high + reach / 4));
  }
  const pad = Math.max((high - low) * 0.06, 1e-3);
  return [low - pad, high + pad];
}

function scales(panel, duration, width, height) {
  const [low, high] = value_range(panel);
  const x = (t) => kLeft + (t / duration) * (width - kLeft - kRight);
  const y = (value) => kTop + ((high - value) / (high - low)) * (height - kTop - kBottom);
  return { low, high, x, y };
}

const place = (value) => value.toFixed(1);

function band_path(panel, { x, y, low, high }) {
  const clamp = (value) => Math.min(Math.max(value, low), high);
  const top = panel.band.map(([t0, t1, , upper]) => `${place(x(t0))},${place(y(clamp(upper)))} ${place(x(t1))},${place(y(clamp(upper)))}`);
  const bottom = panel.band.map(([t0, t1, lower]) => `${place(x(t1))},${place(y(clamp(lower)))} ${place(x(t0))},${place(y(clamp(lower)))}`);
  return `<polygon class="band" points="${top.join(' ')} ${bottom.reverse().join(' ')}"/>`;
}

function axes(scale, duration, width, height) {
  const { low, high, x, y } = scale;
  const value_digits = tick_digits(tick_step(high - low, 4));
  const values = ticks(low, high, 4).map((value) => `<line class="grid" x1="${kLeft}" x2="${width - kRight}" y1="${place(y(value))}" y2="${place(y(value))}"/>` +
      `<text class="tick" x="${kLeft - 6}" y="${place(y(value) + 3.5)}" text-anchor="end">${fixed(value, value_digits)}</text>`);
  const time_digits = tick_digits(tick_step(duration, 5));
  const times = ticks(0, duration, 5).map((t) => `<text class="tick" x="${place(x(t))}" y="${height - 5}" text-anchor="middle">${fixed(t, time_digits)}</text>`);
  return values.join('') + times.join('');
}

function speed_gradient(id, scale, top_speed) {
  return `<defs><linearGradient id="${id}" gradientUnits="userSpaceOnUse" x1="0" x2="0" ` +
      `y1="${place(scale.y(0))}" y2="${place(scale.y(top_speed))}">${speed_stops()}</linearGradient></defs>`;
}

/// One panel as SVG text. `junctions` are the times between segments; `top_speed` anchors the speed colours.
export function plot_svg(panel, { duration, junctions, width, height, top_speed, id }) {
  const scale = scales(panel, duration, width, height);
  const { x, y } = scale;
  const points = panel.line.map(([t, value]) => `${place(x(t))},${place(y(value))}`).join(' ');
  const is_speed = panel.colour === 'speed';
  const stroke = is_speed ? `class="line" stroke="url(#${id})"` : `class="line ${panel.colour}"`;
  const bottom = height - kBottom;
  const marks = junctions.map((t) => `<line class="junction" x1="${place(x(t))}" x2="${place(x(t))}" y1="${bottom}" y2="${bottom - 5}"/>`);
  const limits = (panel.limits ?? []).map((limit) => `<line class="limit" x1="${kLeft}" x2="${width - kRight}" y1="${place(y(limit))}" y2="${place(y(limit))}"/>`);
  return `<svg viewBox="0 0 ${width} ${height}" width="${width}" height="${height}" role="img" aria-label="${escape_html(panel.title)} over time">` +
      (is_speed ? speed_gradient(id, scale, top_speed) : '') + (panel.band ? band_path(panel, scale) : '') +
      axes(scale, duration, width, height) + marks.join('') + limits.join('') +
      `<polyline fill="none" ${stroke} points="${points}"/>` +
      `<g class="cursor" visibility="hidden"><line y1="${kTop}" y2="${bottom}"/><circle r="3.5"/></g></svg>`;
}

/// Draws panels into `host` and keeps one cursor over all of them. `on_time(t or null)` follows the pointer.
export class Plots {
  constructor(host, panels, options) {
    this.panels = panels;
    this.options = options;
    this.figures = panels.map((panel) => this.#figure(panel));
    host.replaceChildren(...this.figures);
    host.addEventListener('pointerleave', () => options.on_time(null));
    new ResizeObserver(() => this.#draw()).observe(host);
    this.#draw();
  }

  #figure(panel) {
    const figure = document.createElement('figure');
    figure.innerHTML = `<figcaption><span>${escape_html(panel.title)}</span><output></output></figcaption><div></div>`;
    const plot = figure.lastElementChild;
    plot.addEventListener('pointermove', (event) => {
      const left = plot.getBoundingClientRect().left;
      const t = ((event.clientX - left - kLeft) / (this.width - kLeft - kRight)) * this.options.duration;
      this.options.on_time(Math.min(Math.max(t, 0), this.options.duration));
    });
    return figure;
  }

  #draw() {
    const width = Math.floor(this.figures[0].lastElementChild.clientWidth);
    if (width < 80 || width === this.width) return;
    this.width = width;
    this.height = 150;
    this.figures.forEach((figure, i) => {
      figure.lastElementChild.innerHTML = plot_svg(this.panels[i], { ...this.options, width, height: this.height, id: `speed-${i}` });
    });
    this.set_time(this.time ?? null);
  }

  /// Moves the cursor of every panel to time t; null hides it.
  set_time(t) {
    this.time = t;
    this.figures.forEach((figure, i) => this.#move_cursor(figure, this.panels[i], t));
  }

  #move_cursor(figure, panel, t) {
    const cursor = figure.querySelector('.cursor');
    const readout = figure.querySelector('output');
    cursor?.setAttribute('visibility', t === null ? 'hidden' : 'visible');
    if (t === null || !cursor) {
      readout.textContent = panel.unit;
      return;
    }
    const { x, y } = scales(panel, this.options.duration, this.width, this.height);
    const value = panel.at(t);
    cursor.firstElementChild.setAttribute('x1', x(t));
    cursor.firstElementChild.setAttribute('x2', x(t));
    cursor.lastElementChild.setAttribute('cx', x(t));
    cursor.lastElementChild.setAttribute('cy', y(value));
    readout.textContent = `${fixed(value, 3)} ${panel.unit}`;
  }
}
