import { data_hull, decode_boxes, hull } from './boxes_data.js';
import { kSpeedGradient, speed_colour } from './colours.js';
import { fixed, html } from './markup.js';
import { headline, plan_heading, plan_numbers } from './numbers.js';
import { outlined_boxes } from './outlined_boxes.js';
import { ball, path_tube } from './path_tube.js';
import { plan_panels } from './plan_plots.js';
import { Plots } from './plots.js';
import { add_rulers } from './rulers.js';
import { solid_boxes } from './solid_boxes.js';
import { connect_theme, on_theme } from './theme.js';
import { box_margin, norm, Trajectory } from './trajectory.js';
import { add_mark, band_at_start, header_markup, legend_markup, open_view, surroundings } from './view_frame.js';
import { connect_panel, panel_markup } from './view_panel.js';

// The page of a swiftlet-plan/1: heading, figures, 3-D view, plots, numbers. All but the view works without WebGL.

export function show_plan_page(host, report) {
  const { plan, title } = report;
  const trajectory = plan.segments?.length ? new Trajectory(plan.segments) : null;
  host.innerHTML = page_markup(title, report, trajectory);
  connect_theme(host);
  const view = make_view(host.querySelector('.view'), report, trajectory);
  if (trajectory) connect_plots(host.querySelector('.plots'), plan, trajectory, view);
}

function page_markup(title, report, trajectory) {
  const { plan, obstacles, version } = report;
  return html`${header_markup(version, plan_heading(title, plan))}
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
  const view = open_view(host);
  if (!view) return null;
  add_layers(view, plan, obstacles, trajectory, all);
  host.insertAdjacentHTML('beforeend', panel_markup(layers_of(plan, obstacles, trajectory), [all[2], all[5]], band_at_start(flown, all)).text);
  if (trajectory) host.insertAdjacentHTML('beforeend', legend_markup('speed', `${fixed(top_speed(plan, trajectory), 2)} m/s`).text);
  const framed = plan.corridor ? surroundings(flown, all) : all;
  connect_panel(host, view, framed);
  view.recolour();
  on_theme(() => view.recolour());
  view.fit(framed, 'oblique');
  return view;
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
    const samples = trajectory.samples(1200);
    const fastest = top_speed(plan, trajectory);
    view.add('path', path_tube(samples.map((sample) => sample.position), { radius: radius / 8, tint: (i) => speed_colour(norm(samples[i].velocity) / fastest) }));
    view.add('vehicle', ball([0, 0, 0], { radius, least: 0.004, colour: '--vehicle', opacity: 0.35 }));
    view.show('vehicle', false);
  }
  for (const end of ['start', 'goal']) {
    const position = plan.request?.[end]?.position;
    if (position?.every(Number.isFinite)) add_mark(view, end, end, position, { radius: radius / 3, kind: end });
  }
}

function connect_plots(host, plan, trajectory, view) {
  const readout = host.parentElement.querySelector('h2 output');
  const follow = (t) => {
    plots.set_time(t);
    readout.textContent = t === null ? '' : `at ${fixed(t, 2)} s`;
    view?.place('vehicle', t === null ? null : trajectory.sample(t).position);
  };
  const plots = new Plots(host, plan_panels(plan, trajectory, top_speed(plan, trajectory)), {
    duration: trajectory.duration,
    junctions: trajectory.starts.slice(1, -1),
    on_time: follow,
  });
}
