import { card, figure, file_name, row } from './cards.js';
import { count, fixed, html, significant, time_span, vector } from './markup.js';

// The numbers of a swiftlet-flight/1 as markup. Every field may be absent.

const centimetres = (metres) => (typeof metres === 'number' ? fixed(100 * metres, 1) : '–');

function arrivals(report) {
  return report.events.filter((event) => event.kind === 'arrival').length;
}

export function flight_heading(title, report) {
  const { flight, goals } = report;
  const arrived = flight.status === 'arrived';
  const text = flight.reason ?? (arrived ? `All of its ${goals.length === 1 ? 'way' : `${goals.length} goals`} flown${flight.landed ? ', and landed' : ''}.` : '');
  return html`<div><h1>${title}</h1><p>${text}</p></div><span class="pill ${arrived ? 'good' : 'bad'}">${String(flight.status ?? 'unknown').replace(/_/g, ' ')}</span>`;
}

/// The few figures that matter, in large type.
export function flight_headline(report) {
  const { flight, tracking_tube: tube, goals, plans } = report;
  const { rms, max } = flight.tracking ?? {};
  const reached = arrivals(report);
  const kept = typeof max !== 'number' || !tube ? '' : max <= tube ? 'good' : 'bad';
  const hit = typeof flight.flown_clearance === 'number' && flight.flown_clearance < report.vehicle_radius;
  return html`<dl class="headline">
    ${figure('Flown', fixed(flight.flown_duration, 1), 's')}
    ${figure('Goals reached', html`${reached}<small>of ${goals.length}</small>`, '', reached < goals.length ? 'bad' : '')}
    ${figure('Tracking error, RMS', centimetres(rms), 'cm')}
    ${figure('Tracking error, largest', centimetres(max), 'cm', kept)}
    ${figure('Clearance of the centre', fixed(flight.flown_clearance, 2), 'm', hit ? 'bad' : '')}
    ${figure('Plans', count(plans.count), '')}
  </dl>`;
}

/// The events as a list of buttons that lead to their moments.
export function event_list(events) {
  if (events.length === 0) return html`<p class="key">Nothing was noted.</p>`;
  return html`<ol class="card event-list">${events.map((event, i) => html`<li><button type="button" data-event="${i}"><b>${fixed(event.t, 2)} s</b><i class="event ${event.kind}"></i>
    <span>${event.what}</span></button></li>`)}</ol>`;
}

function flight_card({ flight, track_length, goals, vehicle_radius }) {
  return card('Flight', [
    row('Status', String(flight.status ?? '–').replace(/_/g, ' ')),
    flight.state && row('At its end', `${flight.state}${flight.landed ? ', on the ground' : ''}`),
    row('Goals', count(goals.length)),
    row('Way flown', fixed(track_length, 1), 'm'),
    row('Duration', fixed(flight.flown_duration, 2), 's'),
    typeof flight.max_speed === 'number' && row('Largest speed', fixed(flight.max_speed, 3), 'm/s'),
    row('Clearance of the centre', significant(flight.flown_clearance, 3), 'm'),
    row('Radius of the vehicle', significant(vehicle_radius), 'm'),
  ]);
}

function tracking_card({ flight, tracking_tube }) {
  const { rms, max } = flight.tracking ?? {};
  const margins = flight.margins;
  return card('Tracking and margins', [
    row('Error, RMS', centimetres(rms), 'cm'),
    row('Error, largest', centimetres(max), 'cm'),
    row('Tube', centimetres(tracking_tube), 'cm'),
    margins && row('Radius of the map', significant(margins.map_radius), 'm'),
    margins && row('for the vehicle', significant(margins.vehicle_radius), 'm'),
    margins && row('for errors of the map', significant(margins.map_error), 'm'),
    margins && row('for tracking', significant(margins.tracking_tube), 'm'),
  ]);
}

function request_card({ flight }) {
  const request = flight.request;
  if (!request) return null;
  const limit = (label, value, unit) => typeof value === 'number' && row(label, significant(value), unit);
  return card('Request', [
    flight.plan?.map && row('Map', file_name(flight.plan.map.path)),
    row('Start', vector(request.start, 2), 'm'),
    request.setpoint && row('Set-points', request.setpoint),
    limit('Speed limit', request.vmax, 'm/s'),
    limit('Acceleration limit', request.amax, 'm/s²'),
    limit('Jerk limit', request.jmax, 'm/s³'),
    request.wind && row('Wind', vector(request.wind, 1), 'm/s'),
    limit('Gusts', request.gust, 'm/s'),
    limit('Delay of the link', request.link_delay, 's'),
    row('Seed', request.seed ?? '–'),
    typeof request.in_process === 'boolean' && row('Time', request.in_process ? 'lock-step' : 'real, over a pseudo-terminal'),
  ]);
}

const kLink = { messages_in: 'Messages in', messages_out: 'Messages out', crc_errors: 'Damaged frames', bytes_in: 'Bytes in', bytes_out: 'Bytes out',
                lost: 'Frames lost', unsent: 'Frames not sent', load_in: 'Share of the line, in', load_out: 'Share of the line, out' };

function link_card({ flight }) {
  if (!flight.link) return null;
  const rows = Object.entries(flight.link).filter(([, value]) => typeof value === 'number').map(([key, value]) => {
    const label = kLink[key] ?? key.replace(/_/g, ' ');
    return key.startsWith('load_') ? row(label, fixed(100 * value, 1), '%') : row(label, Number.isInteger(value) ? count(value) : significant(value));
  });
  const jitter = time_span(1e6 * flight.setpoints?.jitter_p99);
  return card('Link', [rows, flight.setpoints && row('Set-points', count(flight.setpoints.count)),
                       typeof flight.setpoints?.jitter_p99 === 'number' && row('Jitter, 99 %', jitter.value, jitter.unit)]);
}

function plan_table({ plans, flight }) {
  if (plans.shown.length === 0) return null;
  const made = new Map((flight.plans ?? []).map((plan) => [plan.id, plan]));
  const rows = plans.shown.map((plan) => {
    const work = time_span(made.get(plan.number)?.total_us);
    return html`<tr><td>${plan.number}</td><td>${fixed(plan.committed, 2)}</td><td>${fixed(plan.duration, 2)}</td><td>${fixed(plan.length, 2)}</td>
      <td>${count(plan.boxes.length)}</td><td>${work.value} ${work.unit}</td></tr>`;
  });
  const hidden = plans.count - plans.shown.length;
  return html`<details class="card full"><summary><h3>Plans, one by one</h3></summary><div class="scroll"><table class="list">
    <thead><tr><th>plan</th><th>committed [s]</th><th>duration [s]</th><th>length [m]</th><th>boxes</th><th>made in</th></tr></thead>
    <tbody>${rows}</tbody></table></div>${hidden > 0 && html`<p>${count(hidden)} more that were soon replaced are left out.</p>`}</details>`;
}

function fault_table({ flight }) {
  if (!flight.faults?.length) return null;
  const rows = flight.faults.map((fault) => html`<tr><td>${fault.fault}</td><td>${fixed(fault.t, 2)}</td><td>${fault.what ?? 'flown through'}</td>
    <td>${fixed(fault.after, 3)}</td><td>${fixed(fault.settled, 3)}</td></tr>`);
  return html`<section class="card full"><h3>Faults and reactions</h3><div class="scroll"><table class="list">
    <thead><tr><th>fault</th><th>at [s]</th><th>reaction</th><th>after [s]</th><th>settled after [s]</th></tr></thead><tbody>${rows}</tbody></table></div></section>`;
}

export function flight_numbers(report) {
  return html`<div class="cards">${flight_card(report)}${tracking_card(report)}${request_card(report)}${link_card(report)}${
    fault_table(report)}${plan_table(report)}</div>`;
}
