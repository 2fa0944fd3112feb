import { data_hull, decode_boxes, hull } from './boxes_data.js';
import { kSpeedGradient, speed_colour } from './colours.js';
import { event_list, flight_heading, flight_headline, flight_numbers } from './flight_numbers.js';
import { flight_panels, tracking_top } from './flight_plots.js';
import { decode_channel, FlightTrack, last_at, spans } from './flight_track.js';
import { fixed, html } from './markup.js';
import { outlined_boxes } from './outlined_boxes.js';
import { ball, path_tube } from './path_tube.js';
import { Plots } from './plots.js';
import { quadrotor } from './quadrotor.js';
import { add_rulers } from './rulers.js';
import { solid_boxes } from './solid_boxes.js';
import { connect_theme, on_theme } from './theme.js';
import { Player, timeline_markup } from './timeline.js';
import { add_mark, band_at_start, header_markup, legend_markup, open_view, surroundings } from './view_frame.js';
import { connect_panel, panel_markup } from './view_panel.js';

// The page of a flight: heading, figures, 3-D replay, timeline, plots, events, numbers. All but the replay in 3-D works
// without WebGL.

const kMostPathPoints = 8000;

export function show_flight_page(host, report) {
  const track = new FlightTrack(report.samples);
  const duration = track.duration;
  const timed = { ...report, duration, track_length: track.length, states: spans(report.states, duration), phases: spans(report.phases, duration) };
  host.innerHTML = page_markup(timed).text;
  connect_theme(host);
  if (duration === 0) return;
  const view = make_view(host.querySelector('.view'), timed, track);
  connect_replay(host, timed, track, view);
}

function page_markup(report) {
  return html`${header_markup(report.version, flight_heading(report.title, report))}
    ${flight_headline(report)}
    ${report.duration > 0 && html`<section class="view" aria-label="3-D view"></section>${timeline_markup(report)}
    <section><h2>Over time</h2>
      <p class="key"><i class="band"></i>inside the tube <i class="limit"></i>limit <i class="reference"></i>reference <i class="junction"></i>next plan</p>
      <div class="plots three"></div></section>`}
    <section><h2>Events</h2>${event_list(report.events)}</section>
    <section><h2>Numbers</h2>${flight_numbers(report)}</section>`;
}

// ------------------------------------------------------------------------------------------------------- replay

/// Ties the timeline, the plots, the events and the view to one time.
function connect_replay(host, report, track, view) {
  const state = host.querySelector('.pill.state');
  const now = host.querySelector('.now');
  const items = [...host.querySelectorAll('.event-list button')];
  const event_times = report.events.map((event) => event.t);
  const state_times = report.states.map((span) => span.t);
  const show = (t) => {
    const name = report.states[last_at(state_times, t)]?.name ?? '';
    const numbers = moment_text(track, t);
    state.textContent = name;
    state.className = `pill state state-${name}`;
    now.textContent = numbers;
    player.describe(`${fixed(t, 1)} s, ${name}, ${numbers}`);
    const latest = last_at(event_times, t);
    items.forEach((item, i) => (i === latest ? item.setAttribute('aria-current', 'step') : item.removeAttribute('aria-current')));
    plots.set_time(t);
    view?.show_time(t);
  };
  const player = new Player(host.querySelector('.timeline'), { duration: report.duration, events: report.events, on_time: show });
  const plots = new Plots(host.querySelector('.plots'), flight_panels(report, track), {
    duration: report.duration,
    junctions: report.plans.shown.map((plan) => plan.committed).filter((t) => t <= report.duration),
    dragged: true,
    on_time: (t) => player.seek(t),
  });
  items.forEach((item, i) => item.addEventListener('click', () => player.seek(event_times[i])));
  player.seek(Number(/t=([\d.]+)/.exec(location.hash)?.[1] ?? report.duration));
}

function moment_text(track, t) {
  const error = track.value('tracking_error', t);
  return `height ${fixed(track.value('z', t), 2)} m, speed ${fixed(track.value('speed', t), 2)} m/s${
    Number.isFinite(error) ? `, error ${fixed(100 * error, 1)} cm` : ''}`;
}

// ------------------------------------------------------------------------------------------------------ 3-D view

/// The box around everything [m], and the box around the flight.
function contents(report, track) {
  const obstacles = report.obstacles && decode_boxes(report.obstacles);
  const points = track.path(0.2).map((i) => [track.x[i], track.y[i], track.z[i]]);
  const boxes = [...points, ...report.goals].map((point) => [...point, ...point]);
  const flown = hull(boxes);
  return { obstacles, flown, all: hull([obstacles && data_hull(obstacles), flown].filter(Boolean)) };
}

/// The view with show_time(t); null without WebGL.
function make_view(host, report, track) {
  const view = open_view(host);
  if (!view) return null;
  const { obstacles, flown, all } = contents(report, track);
  const show_time = add_layers(view, report, track, obstacles, all);
  host.insertAdjacentHTML('beforeend', panel_markup(layers_of(report, obstacles), [all[2], all[5]], band_at_start(flown, all), camera_markup()).text);
  const top = `${fixed(100 * tracking_top(report, track), 0)} cm`;
  host.insertAdjacentHTML('beforeend', legend_markup('tracking error', top).text);
  const framed = surroundings(flown, all);
  connect_panel(host, view, framed);
  const camera = connect_camera(host, view, report, track);
  on_theme(() => view.recolour());
  view.recolour();
  view.fit(framed, 'oblique');
  if (/follow/.test(location.hash)) camera.follow();
  return {
    show_time(t) {
      show_time(t);
      camera.show_time(t);
      view.request_frame();
    },
  };
}

function layers_of(report, obstacles) {
  return [
    obstacles && { name: 'obstacles', text: 'Obstacles', colour: 'var(--solid-high)', on: true },
    report.plans.shown.length && { name: 'corridor', text: 'Corridor in force', colour: 'var(--corridor)', on: true },
    report.plans.shown.length && { name: 'plan', text: 'Plan in force', colour: 'var(--planned)', on: true },
    { name: 'path', text: 'Flown path', colour: kSpeedGradient, on: true },
    report.tracking_tube && { name: 'tube', text: 'Tracking tube', colour: 'var(--gate)', on: true },
    { name: 'rulers', text: 'Rulers', colour: 'var(--ruler)', on: true },
  ].filter(Boolean);
}

/// Adds everything; returns what shows a time of the flight.
function add_layers(view, report, track, obstacles, all) {
  const radius = report.vehicle_radius;
  if (obstacles) view.add('obstacles', solid_boxes(obstacles));
  add_rulers(view, all);
  const show_path = add_path(view, report, track, radius);
  const show_plan = add_plans(view, report, radius);
  const vehicle = quadrotor({ radius, floor: all[2] });
  view.add('vehicle', vehicle);
  if (report.tracking_tube) view.add('tube', tube_layer(report.tracking_tube));
  report.goals.forEach((goal, i) => add_mark(view, `goal ${i + 1}`, report.goals.length > 1 ? `goal ${i + 1}` : 'goal', goal, { radius: radius / 3, kind: 'goal' }));
  return (t) => {
    vehicle.pose(track.position(t), track.attitude(t));
    show_path(t);
    show_plan(t);
    view.layers.get('tube')?.move(track.reference(t));
  };
}

function add_path(view, report, track, radius) {
  const kept = track.path(Math.max(0.03, report.track_length / kMostPathPoints));
  const times = kept.map((i) => track.t[i]);
  const top = tracking_top(report, track);
  const unknown = [0.55, 0.58, 0.64];
  const path = path_tube(kept.map((i) => [track.x[i], track.y[i], track.z[i]]), {
    radius: radius / 9,
    tint: (k) => (Number.isFinite(track.tracking_error[kept[k]]) ? speed_colour(track.tracking_error[kept[k]] / top) : unknown),
    ahead: true,
  });
  view.add('path', path);
  return (t) => path.reach(last_at(times, t) + 1);
}

/// The reference with the tube around it, in which the vehicle's centre is to be.
function tube_layer(radius) {
  const layer = ball([0, 0, 0], { radius, least: 0, colour: '--gate', opacity: 0.12 });
  const object = layer.object;
  return { ...layer, move(position) {
    object.scale.setScalar(position ? 1 : 0);
    if (position) object.position.set(...position);
  } };
}

/// Corridor and path of the plan in force, made when they are needed. Their layers stay, empty where there is no plan.
function add_plans(view, { plans }, radius) {
  const committed = plans.shown.map((plan) => plan.committed);
  let shown;
  const visible = (name) => view.layers.get(name)?.object.visible ?? true;
  const replace = (name, layer) => {
    const on = visible(name);
    view.remove(name);
    view.add(name, layer);
    layer.recolour?.();
    view.show(name, on);
  };
  const show = (t) => {
    const index = last_at(committed, t);
    if (index === shown || plans.shown.length === 0) return;
    shown = index;
    const plan = plans.shown[index];
    replace('corridor', outlined_boxes(plan ? distinct(plan.boxes) : [], { colour: '--corridor', face_opacity: 0.07, edge_opacity: 0.75 }));
    replace('plan', path_tube(plan ? path_points(plan.path) : [], { radius: radius / 14, colour: '--planned', behind: 0.1 }));
  };
  show(-1);
  return show;
}

/// A box that holds several segments is repeated: it is drawn once.
function distinct(boxes) {
  return boxes.filter((box, i) => i === 0 || box.some((value, k) => value !== boxes[i - 1][k]));
}

function path_points(path) {
  const [x, y, z] = [path.x, path.y, path.z].map(decode_channel);
  return Array.from(x, (_, i) => [x[i], y[i], z[i]]);
}

// ------------------------------------------------------------------------------------------------------- camera

function camera_markup() {
  return html`<div class="directions camera" role="group" aria-label="Camera">${['free', 'follow'].map((mode) =>
    html`<button type="button" data-camera="${mode}" aria-pressed="${mode === 'free'}">${mode}</button>`)}</div>`;
}

/// The camera stays where it is put, or goes with the vehicle: `follow()` begins that.
function connect_camera(host, view, report, track) {
  const buttons = [...host.querySelectorAll('[data-camera]')];
  let following = false;
  let time = 0;
  const set = (mode) => {
    following = mode === 'follow';
    for (const button of buttons) button.setAttribute('aria-pressed', button.dataset.camera === mode);
    view.follow(following ? track.position(time) : null);
  };
  const follow = () => {
    set('follow');
    const heading = (Math.PI / 180) * track.value('heading', time);
    const distance = Math.max(11 * report.vehicle_radius, 1.5);
    view.stand_off([-Math.cos(heading), -Math.sin(heading), 0.8].map((share) => share * distance));
  };
  buttons.forEach((button) => button.addEventListener('click', () => (button.dataset.camera === 'follow' ? follow() : set('free'))));
  host.querySelectorAll('[data-direction]').forEach((button) => button.addEventListener('click', () => set('free')));
  return {
    follow,
    show_time(t) {
      time = t;
      if (following) view.follow(track.position(t));
    },
  };
}
