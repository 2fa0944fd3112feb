import { data_hull, decode_boxes, hull } from './boxes_data.js';
import { cell_boxes } from './cell_boxes.js';
import { CellMap, first_hit, widest_height } from './cell_map.js';
import { kComponentColours, kOtherComponents, kSpeedGradient } from './colours.js';
import { count, fixed, html, significant } from './markup.js';
import { cell_line, map_heading, map_headline, map_numbers } from './map_numbers.js';
import { outlined_boxes } from './outlined_boxes.js';
import { add_rulers } from './rulers.js';
import { SectionView } from './section_view.js';
import { solid_boxes } from './solid_boxes.js';
import { connect_theme, on_theme } from './theme.js';
import { header_markup, open_view } from './view_frame.js';
import { connect_panel, panel_markup } from './view_panel.js';

// The page of a swiftlet-map/1: heading, figures, 3-D view, section, numbers. All but the view works without WebGL.

export function show_map_page(host, report) {
  host.innerHTML = page_markup(report).text;
  connect_theme(host);
  const map = new CellMap(report);
  const obstacles = report.obstacles && decode_boxes(report.obstacles);
  const bounds = hull([data_hull(map.cells), obstacles && data_hull(obstacles)].filter(Boolean));
  if (!bounds) return;
  const height = map.count > 0 ? widest_height(map.cells) : (bounds[2] + bounds[5]) / 2;
  const scene = { map, obstacles, windows: decode_boxes({ ...report.grid, boxes: report.windows.boxes }), bounds, height };
  const select = (cell) => {
    host.querySelector('.chosen').innerHTML = cell < 0 ? kHint : cell_line(map, cell).text;
    view?.select(cell);
    section.set({ selected: cell });
  };
  const view = make_view(host.querySelector('.view'), scene, select);
  const section = make_section(host.querySelector('.section'), scene, select);
  const paint = (by) => {
    const colours = map.colours(by);
    view?.paint(colours);
    section.set({ colours });
    host.querySelector('.scale').innerHTML = scale_markup(by, map, report.components).text;
  };
  connect_colouring(host.querySelector('.colouring'), paint);
  select(-1);
}

const kHint = 'A click on a cell, above or here, shows its extent and its windows.';

function page_markup(report) {
  const { map, title, version, note, cells } = report;
  const thinned = cells.shown < cells.count;
  return html`${header_markup(version, map_heading(title, map, note))}
    ${map_headline(map)}
    <section class="view" aria-label="3-D view"></section>
    <p class="key colouring"><span>Cells coloured by</span>${colouring_markup(map)}<span class="scale"></span></p>
    <p class="key"><span class="chosen"></span></p>
    ${thinned && html`<p class="key">The page holds the ${count(cells.shown)} largest of ${count(cells.count)} cells, with ${fixed(100 * cells.shown_share, 1)} % of the free space.</p>`}
    <section><h2>Section <output></output></h2><div class="section card"></div></section>
    <section><h2>Numbers</h2>${map_numbers(report)}</section>`;
}

/// Components first where they are what there is to see.
function colouring_markup(map) {
  const first = map.largest_component < 0.9 ? 'component' : 'volume';
  return html`<span class="directions" role="group">${['volume', 'component'].map((by) =>
    html`<button type="button" data-colouring="${by}" aria-pressed="${by === first}">${by}</button>`)}</span>`;
}

function connect_colouring(host, paint) {
  const buttons = [...host.querySelectorAll('[data-colouring]')];
  const choose = (chosen) => {
    for (const button of buttons) button.setAttribute('aria-pressed', button === chosen);
    paint(chosen.dataset.colouring);
  };
  for (const button of buttons) button.addEventListener('click', () => choose(button));
  choose(buttons.find((button) => button.getAttribute('aria-pressed') === 'true'));
}

function scale_markup(by, map, components) {
  if (by === 'volume') {
    const [least, most] = map.volume_range;
    return html`<b>${significant(least, 2)}</b><i class="gradient" style="background:${kSpeedGradient}"></i><b>${significant(most, 2)} m³</b>`;
  }
  const entry = (colour, text) => html`<i class="swatch" style="background:${colour}"></i>${text}`;
  return html`${components.map(({ share }, rank) => entry(kComponentColours[rank], `${fixed(100 * share, 1)} %`))}${
    components.length === kComponentColours.length && entry(kOtherComponents, 'others')}`;
}

// ------------------------------------------------------------------------------------------------------ 3-D view

/// The view with { paint(colours), select(cell) }; null without WebGL.
function make_view(host, scene, select) {
  const view = open_view(host);
  if (!view) return null;
  const { map, bounds, height } = scene;
  const cells = add_layers(view, scene);
  host.insertAdjacentHTML('beforeend', panel_markup(layers_of(scene), [bounds[2], bounds[5]], [bounds[2], height]).text);
  connect_panel(host, view, bounds);
  connect_clicks(host, view, scene, select);
  on_theme(() => view.recolour());
  view.recolour();
  view.fit(bounds, 'oblique');
  return {
    paint(colours) {
      cells?.paint(colours);
      view.request_frame();
    },
    select(cell) {
      view.remove('extent');
      view.remove('chosen');
      if (cell < 0) return;
      view.add('extent', outlined_boxes([map.extent(cell)], { colour: '--ink', face_opacity: 0.08, edge_opacity: 1 }));
      view.add('chosen', outlined_boxes([map.box(cell), ...map.windows(cell)], { colour: '--gate', face_opacity: 0.3, edge_opacity: 1 }));
      view.recolour();
    },
  };
}

function layers_of({ map, obstacles, windows }) {
  return [
    obstacles && { name: 'obstacles', text: 'Obstacles', colour: 'var(--solid-high)', on: true },
    map.count > 0 && { name: 'cells', text: 'Cells', colour: kSpeedGradient, on: true },
    windows.data.length > 0 && { name: 'windows', text: 'Windows', colour: 'var(--gate)', on: false },
    { name: 'rulers', text: 'Rulers', colour: 'var(--ruler)', on: true },
  ].filter(Boolean);
}

/// Adds everything; returns the layer of the cells, null without any.
function add_layers(view, { map, obstacles, windows, bounds }) {
  if (obstacles) view.add('obstacles', solid_boxes(obstacles));
  add_rulers(view, bounds);
  if (windows.data.length > 0) view.add('windows', cell_boxes(windows, { colour: '--gate', opacity: 0.25 }));
  if (map.count === 0) return null;
  const cells = cell_boxes(map.cells, { colours: new Uint8Array(3 * map.count) });
  view.add('cells', cells);
  return cells;
}

/// A click chooses the cell that is seen there; on an obstacle or on nothing it chooses none.
function connect_clicks(host, view, { map, obstacles }, select) {
  const shown = (name) => host.querySelector(`.layers input[name=${name}]`)?.checked;
  view.on_click((origin, direction) => {
    const band = [...host.querySelectorAll('.heights input')].map((input) => Number(input.value));
    const cell = shown('cells') ? first_hit(map.cells, origin, direction, band) : null;
    const solid = obstacles && shown('obstacles') ? first_hit(obstacles, origin, direction, band) : null;
    select(cell && !(solid?.distance < cell.distance) ? cell.index : -1);
  });
}

// ------------------------------------------------------------------------------------------------------- section

function make_section(host, { map, obstacles, bounds, height }, select) {
  host.innerHTML = html`<label class="level"><span>Height</span><input type="range" min="${bounds[2]}" max="${bounds[5]}"
    step="${Math.max((bounds[5] - bounds[2]) / 400, 1e-3)}" value="${height}" aria-label="Height of the section [m]"><output></output></label><div class="plan"></div>`.text;
  const [level, level_text] = host.querySelectorAll('input, output');
  const readout = host.parentElement.querySelector('h2 output');
  const section = new SectionView(host.querySelector('.plan'), bounds, { map, obstacles, on_point(point, clicked) {
    readout.textContent = point ? `at ${point.map((value) => fixed(value, 2)).join(', ')} m` : '';
    if (clicked) select(map.at(point));
  } });
  const move = () => {
    level_text.textContent = `${fixed(Number(level.value), 2)} m`;
    section.set({ height: Number(level.value) });
  };
  level.addEventListener('input', move);
  on_theme(() => section.draw());
  move();
  return section;
}
