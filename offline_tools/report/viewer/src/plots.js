import { speed_stops } from './colours.js';
import { escape_html, fixed } from './markup.js';
import { tick_digits, tick_step, ticks } from './ticks.js';

// Small multiples over time with one cursor. A panel is
//   { title, unit, line: [[t, value], ...], colour: class name or 'scale', top: value at the end of that colour scale,
//     other: a line drawn beneath, limits: [number], least: a value to be shown, band: [[t0, t1, low, high], ...],
//     at: (t) => value, digits: of that in words }
// Where a line has NaN it is interrupted.

const kLeft = 44;
const kRight = 8;
const kTop = 8;
const kBottom = 20;

/// The value range of a panel: everything drawn but the band, which is cut where it is far wider than the line.
export function value_range(panel) {
  let low = Infinity;
  let high = -Infinity;
  const include = (value) => {
    if (Number.isNaN(value)) return;
    low = Math.min(low, value);
    high = Math.max(high, value);
  };
  for (const [, value] of [...panel.line, ...(panel.other ?? []), [0, panel.least ?? NaN]]) include(value);
  for (const limit of panel.limits ?? []) include(limit);
  const reach = Math.max(high - low, 0.5);
  for (const [, , band_low, band_high] of panel.band ?? []) {
    include(Math.max(band_low, low - reach / 4));
    include(Math.min(band_high, high + reach / 4));
  }
  if (low > high) return [0, 1];
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

function scale_gradient(id, scale, top) {
  return `<defs><linearGradient id="${id}" gradientUnits="userSpaceOnUse" x1="0" x2="0" ` +
      `y1="${place(scale.y(0))}" y2="${place(scale.y(top))}">${speed_stops()}</linearGradient></defs>`;
}

/// A line as one polyline a stretch without NaN.
function polylines(line, { x, y }, style) {
  const stretches = [[]];
  for (const [t, value] of line) {
    if (!Number.isNaN(value)) stretches.at(-1).push(`${place(x(t))},${place(y(value))}`);
    else if (stretches.at(-1).length > 0) stretches.push([]);
  }
  return stretches.filter((points) => points.length > 0).map((points) => `<polyline fill="none" ${style} points="${points.join(' ')}"/>`).join('');
}

/// One panel as SVG text. `junctions` are the times between segments.
export function plot_svg(panel, { duration, junctions, width, height, id }) {
  const scale = scales(panel, duration, width, height);
  const { x, y } = scale;
  const on_scale = panel.colour === 'scale';
  const bottom = height - kBottom;
  const marks = junctions.map((t) => `<line class="junction" x1="${place(x(t))}" x2="${place(x(t))}" y1="${bottom}" y2="${bottom - 5}"/>`);
  const limits = (panel.limits ?? []).map((limit) => `<line class="limit" x1="${kLeft}" x2="${width - kRight}" y1="${place(y(limit))}" y2="${place(y(limit))}"/>`);
  return `<svg viewBox="0 0 ${width} ${height}" width="${width}" height="${height}" role="img" aria-label="${escape_html(panel.title)} over time">` +
      (on_scale ? scale_gradient(id, scale, panel.top) : '') + (panel.band ? band_path(panel, scale) : '') +
      axes(scale, duration, width, height) + marks.join('') + limits.join('') +
      polylines(panel.other ?? [], scale, 'class="line other"') +
      polylines(panel.line, scale, on_scale ? `class="line" stroke="url(#${id})"` : `class="line ${panel.colour}"`) +
      `<g class="cursor" visibility="hidden"><line y1="${kTop}" y2="${bottom}"/><circle r="3.5"/></g></svg>`;
}

/// Draws panels into `host` and keeps one cursor over all of them. `on_time(t)` follows the pointer, and is null when it
/// leaves; with `dragged` it follows only the pressed one, and the cursor stays.
export class Plots {
  constructor(host, panels, options) {
    this.panels = panels;
    this.options = options;
    this.figures = panels.map((panel) => this.#figure(panel));
    host.replaceChildren(...this.figures);
    if (!options.dragged) host.addEventListener('pointerleave', () => options.on_time(null));
    new ResizeObserver(() => this.#draw()).observe(host);
    this.#draw();
  }

  #figure(panel) {
    const figure = document.createElement('figure');
    figure.innerHTML = `<figcaption><span>${escape_html(panel.title)}</span><output></output></figcaption><div></div>`;
    const plot = figure.lastElementChild;
    const follow = (event) => {
      if (this.options.dragged && event.buttons === 0) return;
      const left = plot.getBoundingClientRect().left;
      const t = ((event.clientX - left - kLeft) / (this.width - kLeft - kRight)) * this.options.duration;
      this.options.on_time(Math.min(Math.max(t, 0), this.options.duration));
    };
    plot.addEventListener('pointerdown', follow);
    plot.addEventListener('pointermove', follow);
    return figure;
  }

  #draw() {
    const width = Math.floor(this.figures[0].lastElementChild.clientWidth);
    if (width < 80 || width === this.width) return;
    this.width = width;
    const height = 150;
    this.scales = this.panels.map((panel) => scales(panel, this.options.duration, width, height));
    this.figures.forEach((figure, i) => {
      figure.lastElementChild.innerHTML = plot_svg(this.panels[i], { ...this.options, width, height, id: `scale-${i}` });
    });
    this.set_time(this.time ?? null);
  }

  /// Moves the cursor of every panel to time t; null hides it.
  set_time(t) {
    this.time = t;
    this.figures.forEach((figure, i) => this.#move_cursor(figure, i, t));
  }

  #move_cursor(figure, i, t) {
    const cursor = figure.querySelector('.cursor');
    const readout = figure.querySelector('output');
    const { unit, at, digits = 3 } = this.panels[i];
    cursor?.setAttribute('visibility', t === null ? 'hidden' : 'visible');
    if (t === null || !cursor) {
      readout.textContent = unit;
      return;
    }
    const { x, y } = this.scales[i];
    const value = at(t);
    cursor.firstElementChild.setAttribute('x1', x(t));
    cursor.firstElementChild.setAttribute('x2', x(t));
    cursor.lastElementChild.setAttribute('visibility', Number.isFinite(value) ? 'inherit' : 'hidden');
    cursor.lastElementChild.setAttribute('cx', x(t));
    if (Number.isFinite(value)) cursor.lastElementChild.setAttribute('cy', y(value));
    readout.textContent = `${fixed(value, digits)} ${unit}`;
  }
}
