import { data_hull, decode_boxes, hull } from './boxes_data.js';
import { kSpeedGradient } from './colours.js';
import { fixed, html } from './markup.js';
import { headline, plan_heading, plan_numbers } from './numbers.js';
import { outlined_boxes } from './outlined_boxes.js';
import { ball, path_tube } from './path_tube.js';
import { plan_panels } from './plan_plots.js';
import { Plots } from './plots.js';
import { add_rulers } from './rulers.js';
import { View } from './scene.js';
import { solid_boxes } from './solid_boxes.js';
import { on_theme, toggle_theme } from './theme.js';
import { box_margin, norm, Trajectory } from './trajectory.js';
import { connect_panel, panel_markup } from './view_panel.js';

// The page of a swiftlet-plan/1: heading, figures, 3-D view, plots, numbers. All but the view works without WebGL.

export function show_plan_page(host, report) {
  const { plan, title } = report;
  const trajectory = plan.segments?.length ? new Trajectory(plan.segments) : null;
  host.innerHTML = page_markup(title, report, trajectory);
  host.querySelector('.theme').addEventListener('click', toggle_theme);
  const view = make_view(host.querySelector('.view'), report, trajectory);
  if (trajectory) connect_plots(host.querySelector('.plots'), plan, trajectory, view);
}

function page_markup(title, report, trajectory) {
  const { plan, obstacles, version } = report;
  return html`<header><a class="brand">swiftlet <small>${version}</small></a>${plan_heading(title, plan)}
      <button type="button" class="theme" aria-label="Light or dark" title="Light or dark"></button></header>
    ${headline(plan)}
    <section class="view" aria-label="3-D view"></section>
    ${trajectory && html`<section><h2>Over time <output></output></h2>
      <p class="key"><i class="band"></i>inside the box of the moment <i class="limit"></i>limit <i class="junction"></i>next segment</p>
      <div class="plots"></div></section>`}
    <section><h2>Numbers</h2>${plan_numbers(plan, obstacles)}</section>`.text;
}

/// The box around everything [m], null around nothing, and the box around the flight, null where there is none inside.
/// An end far outside the map does not stretch the view.
function contents(plan, obstacles) {
  const ends = [plan.request?.start, plan.request?.goal].filter((state) => state?.position?.every(Number.isFinite));
  const points = ends.map((state) => [...state.position, ...state.position]);
  const solid = obstacles && data_hull(obstacles);
  const all = hull([...(plan.corridor ?? []), solid].filter(Boolean)) ?? hull(points);
  const inside = points.filter((point) => box_margin(all, point.slice(0, 3)) >= 0);
  return { all, flown: hull([...(plan.corridor ?? []), ...inside]) };
}

function make_view(host, report, trajectory) {
  const { plan } = report;
  const obstacles = report.obstacles && decode_boxes(report.obstacles);
  const { flown, all } = contents(plan, obstacles);
  if (!all) return null;
  let view;
  try {
    view = new View(host);
  } catch (error) {
    host.classList.add('missing');
    host.innerHTML = html`<p>The 3-D view needs WebGL 2, which this browser does not offer. Everything else is below.</p>`.text;
    return null;
  }
  add_layers(view, plan, obstacles, trajectory, all);
  host.insertAdjacentHTML('beforeend', panel_markup(layers_of(plan, obstacles, trajectory), [all[2], all[5]], band_at_start(flown, all)).text);
  if (trajectory) host.insertAdjacentHTML('beforeend', legend_markup(top_speed(plan, trajectory)).text);
  const framed = framed_box(plan, flown, all);
  connect_panel(host, view, framed);
  view.recolour();
  on_theme(() => view.recolour());
  view.fit(framed, 'oblique');
  return view;
}

/// The flight with its surroundings: as far again to every side as half its longest edge, within the map. Where there
/// is no flight, everything.
function framed_box(plan, flown, all) {
  if (!plan.corridor) return all;
  const reach = Math.max(flown[3] - flown[0], flown[4] - flown[1], flown[5] - flown[2], 2) / 2;
  return all.map((bound, i) => (i < 3 ? Math.max(bound, flown[i] - reach) : Math.min(bound, flown[i] + reach)));
}

/// What lies above the flight is cut off at the start, so that the page opens with a look into the building.
function band_at_start(flown, all) {
  const above = flown ? flown[5] + 0.02 * (all[5] - all[2]) : all[5];
  return [all[2], Math.min(above, all[5])];
}

function top_speed(plan, trajectory) {
  const certified = plan.certificate?.max_speed_norm;
  return typeof certified === 'number' && certified > 0 ? certified
      : Math.max(1e-3, ...trajectory.samples(300).map((sample) => norm(sample.velocity)));
}

/// A box that holds several segments is repeated, and the gate between the two is the box itself: each is drawn once.
function distinct_boxes(plan) {
  const same = (a, b) => a && b && a.every((value, i) => value === b[i]);
  const corridor = plan.corridor ?? [];
  const gates = plan.gates ?? [];
  return {
    boxes: corridor.filter((box, i) => !same(box, corridor[i - 1])),
    gates: gates.filter((gate, i) => !same(corridor[i], corridor[i + 1])),
  };
}

function layers_of(plan, obstacles, trajectory) {
  const { boxes, gates } = distinct_boxes(plan);
  return [
    obstacles && { name: 'obstacles', text: 'Obstacles', colour: 'var(--solid-high)', on: true },
    boxes.length && { name: 'corridor', text: 'Corridor', colour: 'var(--corridor)', on: true },
    gates.length && { name: 'gates', text: 'Gates', colour: 'var(--gate)', on: true },
    trajectory && { name: 'path', text: 'Path', colour: kSpeedGradient, on: true },
    { name: 'rulers', text: 'Rulers', colour: 'var(--ruler)', on: true },
  ].filter(Boolean);
}

function add_layers(view, plan, obstacles, trajectory, all) {
  if (obstacles) view.add('obstacles', solid_boxes(obstacles));
  add_rulers(view, all);
  const { boxes, gates } = distinct_boxes(plan);
  if (boxes.length) view.add('corridor', outlined_boxes(boxes, { colour: '--corridor', face_opacity: 0.07, edge_opacity: 0.75 }));
  if (gates.length) view.add('gates', outlined_boxes(gates, { colour: '--gate', face_opacity: 0.16, edge_opacity: 0.9 }));
  const radius = plan.map?.radius_m > 0 ? plan.map.radius_m : 0.1;
  if (trajectory) {
    view.add('path', path_tube(trajectory.samples(1200), { radius: radius / 8, top_speed: top_speed(plan, trajectory) }));
    view.add('vehicle', ball([0, 0, 0], { radius, least: 0.004, colour: '--vehicle', opacity: 0.35 }));
    view.show('vehicle', false);
  }
  add_end(view, 'start', plan.request?.start, radius);
  add_end(view, 'goal', plan.request?.goal, radius);
}

function add_end(view, name, state, radius) {
  if (!state?.position?.every(Number.isFinite)) return;
  view.add(name, ball(state.position, { radius: radius / 3, least: 0.005, colour: `--${name}`, opacity: 0.95 }));
  view.label(name, state.position, `end ${name}`, name);
}

function legend_markup(fastest) {
  return html`<div class="legend"><span>speed</span><b>0</b><i style="background:${kSpeedGradient}"></i><b>${fixed(fastest, 2)} m/s</b></div>`;
}

function connect_plots(host, plan, trajectory, view) {
  const readout = host.parentElement.querySelector('h2 output');
  const follow = (t) => {
    plots.set_time(t);
    readout.textContent = t === null ? '' : `at ${fixed(t, 2)} s`;
    view?.place('vehicle', t === null ? null : trajectory.sample(t).position);
  };
  const plots = new Plots(host, plan_panels(plan, trajectory), {
    duration: trajectory.duration,
    junctions: trajectory.starts.slice(1, -1),
    top_speed: top_speed(plan, trajectory),
    on_time: follow,
  });
}
