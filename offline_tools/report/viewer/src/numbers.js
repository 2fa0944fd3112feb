import { card, figure, file_name, row } from './cards.js';
import { count, fixed, html, significant, time_span, vector } from './markup.js';

// The numbers of a swiftlet-plan/1 as markup. Every field may be absent (contract: it then does not exist).

const kStatus = {
  optimal: { tone: 'good', text: 'Optimal and certified.' },
  fallback: { tone: 'fair', text: 'A certified trajectory that is not the optimum.' },
  start_not_free: { tone: 'bad', text: 'The start is not in free space.' },
  goal_not_free: { tone: 'bad', text: 'The goal is not in free space.' },
  no_path: { tone: 'bad', text: 'Start and goal are not connected by free space.' },
  search_capacity: { tone: 'bad', text: 'The search ran out of nodes.' },
  corridor_capacity: { tone: 'bad', text: 'The corridor has more boxes than the planner holds.' },
  infeasible: { tone: 'bad', text: 'No trajectory meets the limits in this corridor.' },
  bad_request: { tone: 'bad', text: 'The request is not usable.' },
};

export function status_of(plan) {
  return { name: String(plan.status ?? 'unknown').replace(/_/g, ' '), ...(kStatus[plan.status] ?? { tone: 'bad', text: '' }) };
}

/// The few figures that matter, in large type.
export function headline(plan) {
  const search = time_span(plan.stats?.search_us);
  const solve = time_span(plan.stats?.trajectory_us);
  const pass = plan.certificate?.pass;
  return html`<dl class="headline">
    ${figure('Length', fixed(plan.length, 2), 'm')}
    ${figure('Duration', fixed(plan.duration, 2), 's')}
    ${figure('Corridor', plan.corridor ? count(plan.corridor.length) : '–', plan.corridor?.length === 1 ? 'box' : 'boxes')}
    ${figure('Search', search.value, search.unit)}
    ${figure('Trajectory', solve.value, solve.unit)}
    ${figure('Certificate', pass === undefined ? '–' : pass ? 'pass' : 'FAIL', '', pass === undefined ? '' : pass ? 'good' : 'bad')}
  </dl>`;
}

function map_card(plan, obstacles) {
  const map = plan.map;
  if (!map) return null;
  return card('Map', [
    row('File', file_name(map.path)),
    row('CRC-32', map.crc32 ?? '–'),
    row('Resolution', significant(map.resolution_m), 'm'),
    row('Vehicle radius', significant(map.radius_m), 'm'),
    row('Obstacle boxes', obstacles ? count(obstacles.count) : '–'),
    obstacles && obstacles.shown < obstacles.count && row('shown, largest first', count(obstacles.shown)),
  ]);
}

function end_rows(name, state) {
  if (!state) return null;
  const moving = (values) => values?.some((value) => value !== 0);
  return [
    row(name, vector(state.position), 'm'),
    moving(state.velocity) && row(html`${name} velocity`, vector(state.velocity), 'm/s'),
    moving(state.acceleration) && row(html`${name} acceleration`, vector(state.acceleration), 'm/s²'),
  ];
}

function request_card(plan) {
  const request = plan.request;
  if (!request) return null;
  return card('Request', [
    end_rows('Start', request.start),
    end_rows('Goal', request.goal),
    row('Speed limit', significant(request.vmax), 'm/s'),
    row('Acceleration limit', significant(request.amax), 'm/s²'),
    row('Limits hold', request.norm === 'euclidean' ? 'for the norm' : 'per axis'),
    request.corridor && row('Corridor', request.corridor === 'cells' && request.relax ? 'cells, relaxed' : request.corridor),
  ]);
}

function blocking_rows(blocking) {
  if (!blocking) return null;
  return [
    row('Blocked in box', count(blocking.box)),
    row('by', `${blocking.axis ?? '–'} ${blocking.bound ?? ''}`),
    row('missing', significant(blocking.missing)),
    row('feasible when stretched by', significant(blocking.stretch)),
  ];
}

function result_card(plan) {
  return card('Result', [
    row('Status', status_of(plan).name),
    plan.fallback_reason && row('Reason', plan.fallback_reason.replace(/_/g, ' ')),
    blocking_rows(plan.blocking),
    row('Length', fixed(plan.length, 3), 'm'),
    row('Duration', fixed(plan.duration, 3), 's'),
    plan.segments && row('Segments', count(plan.segments.length)),
    plan.jerk_cost && row('Jerk cost x, y, z', plan.jerk_cost.map((cost) => significant(cost)).join(', '), 'm²/s⁵'),
  ]);
}

const kWork = {
  search_us: 'Search', trajectory_us: 'Trajectory', total_us: 'Request to certificate', expanded: 'Windows expanded',
  qp_iterations: 'QP iterations', constraints_added: 'Constraints added', active: 'Active at the end', time_scale: 'Time scale',
};

function work_card(plan) {
  if (!plan.stats) return null;
  return card('Work', Object.entries(plan.stats).map(([key, value]) => {
    const label = kWork[key] ?? key.replace(/_/g, ' ');
    if (!key.endsWith('_us')) return row(label, Number.isInteger(value) ? count(value) : significant(value));
    const span = time_span(value);
    return row(label, span.value, span.unit);
  }));
}

/// A bound and how much of it is used, as a number and as a bar.
function bound_row(label, value, limit, unit) {
  const used = typeof limit === 'number' && limit > 0 ? Math.min(value / limit, 1) : null;
  return html`<tr><th>${label}</th><td>${fixed(value, 4)} <small>${unit}</small></td><td>${used === null ? html`<small>no limit</small>`
      : html`<meter min="0" max="1" value="${used.toFixed(4)}"></meter> <small>of ${significant(limit)}</small>`}</td></tr>`;
}

function certificate_card(plan) {
  const certificate = plan.certificate;
  if (!certificate) return null;
  const request = plan.request ?? {};
  const euclidean = request.norm === 'euclidean';
  const rows = (key, limits, limit, unit, name) => [
    ...['x', 'y', 'z'].map((axis, i) => bound_row(`${name} ${axis}`, certificate[key]?.[i], limits?.[i], unit)),
    bound_row(`${name}, norm`, certificate[`${key}_norm`], euclidean ? limit : null, unit),
  ];
  return html`<section class="card wide"><h3>Certificate <span class="pill ${certificate.pass ? 'good' : 'bad'}">${certificate.pass ? 'pass' : 'FAIL'}</span></h3>
    <p>Upper bounds over the whole trajectory, computed from the emitted coefficients apart from the solver.
    Least distance to the faces of its boxes ${significant(certificate.box_margin)} m, tolerance ${significant(certificate.tolerance)}.</p>
    <div class="bounds"><table>${rows('max_speed', plan.qp?.vmax, request.vmax, 'm/s', 'Speed')}</table>
    <table>${rows('max_acceleration', plan.qp?.amax, request.amax, 'm/s²', 'Acceleration')}</table></div></section>`;
}

function size_of(box) {
  return [0, 1, 2].map((axis) => fixed(box[axis + 3] - box[axis], 2)).join(' × ');
}

function corridor_table(plan) {
  if (!plan.corridor?.length) return null;
  const rows = plan.corridor.map((box, i) => html`<tr><td>${i + 1}</td><td>${vector(box.slice(0, 3), 2)}</td><td>${vector(box.slice(3), 2)}</td>
    <td>${size_of(box)}</td><td>${fixed(plan.segments?.[i]?.duration, 3)}</td><td>${plan.gates?.[i] ? size_of(plan.gates[i]) : '–'}</td></tr>`);
  return html`<details class="card full"><summary><h3>Corridor, box by box</h3></summary><div class="scroll"><table class="list">
    <thead><tr><th>box</th><th>low corner [m]</th><th>high corner [m]</th><th>size [m]</th><th>time [s]</th><th>gate to the next [m]</th></tr></thead>
    <tbody>${rows}</tbody></table></div></details>`;
}

export function plan_numbers(plan, obstacles) {
  return html`<div class="cards">${map_card(plan, obstacles)}${request_card(plan)}${result_card(plan)}${work_card(plan)}${
    certificate_card(plan)}${corridor_table(plan)}</div>`;
}

/// The heading of a page: what it is, what it shows, and how it ended.
export function plan_heading(title, plan) {
  const status = status_of(plan);
  return html`<div><h1>${title}</h1><p>${plan.reason ?? status.text}</p></div><span class="pill ${status.tone}">${status.name}</span>`;
}
