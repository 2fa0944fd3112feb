// The parts of the viewer that need no browser: node --test test/viewer.test.js
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import test from 'node:test';

import { data_hull, decode_boxes, hull } from '../src/boxes_data.js';
import { boxes_across, CellMap, first_hit, widest_height } from '../src/cell_map.js';
import { speed_colour } from '../src/colours.js';
import { density_grid } from '../src/density.js';
import { event_list, flight_heading, flight_headline, flight_numbers } from '../src/flight_numbers.js';
import { flight_panels, tracking_top } from '../src/flight_plots.js';
import { decode_channel, FlightTrack, last_at, spans } from '../src/flight_track.js';
import { fixed, html, significant, time_span } from '../src/markup.js';
import { cell_line, map_heading, map_headline, map_numbers } from '../src/map_numbers.js';
import { headline, plan_heading, plan_numbers } from '../src/numbers.js';
import { plan_panels } from '../src/plan_plots.js';
import { plot_svg, value_range } from '../src/plots.js';
import { ticks } from '../src/ticks.js';
import { neighbour_event, timeline_markup } from '../src/timeline.js';
import { box_margin, evaluate, Trajectory } from '../src/trajectory.js';

const plan = JSON.parse(readFileSync(new URL('../../../../tests/data/plan_small.json', import.meta.url)));
const options = { duration: 4, junctions: [2], width: 300, height: 150, id: 'scale' };

test('a polynomial gives value, first and second derivative', () => {
  assert.deepEqual(evaluate([1, 2, 3, 4, 5, 6], 2), [321, 702, 1254]);
});

test('a trajectory is continuous over its junction and clamped to its ends', () => {
  const trajectory = new Trajectory(plan.segments);
  assert.equal(trajectory.duration, 4);
  assert.deepEqual(trajectory.sample(2, 0).position, trajectory.sample(2, 1).position);
  assert.deepEqual(trajectory.sample(-1).position, [0, 0, 1]);
  assert.deepEqual(trajectory.sample(9).position, [1, 1, 1]);
  assert.equal(trajectory.sample(1).velocity[0], 0.9375);
});

test('the segment in force follows the time, a junction belonging to the later one', () => {
  const trajectory = new Trajectory([1, 2, 3].map((duration) => ({ ...plan.segments[0], duration })));
  assert.deepEqual([0, 0.99, 1, 2.99, 3, 6, 7].map((t) => trajectory.segment_at(t)), [0, 0, 1, 1, 2, 2, 2]);
});

test('samples hold both ends of every segment', () => {
  const times = new Trajectory(plan.segments).samples(20).map((sample) => sample.t);
  assert.equal(times.filter((t) => t === 2).length, 2);
  assert.deepEqual([times[0], times.at(-1)], [0, 4]);
});

test('the margin to a box is that of the nearest face, negative outside', () => {
  const box = [0, 0, 0, 4, 4, 4];
  assert.equal(box_margin(box, [2, 1, 2]), 1);
  assert.equal(box_margin(box, [2, 4, 2]), 0);
  assert.equal(box_margin(box, [2, 5, -3]), -3);
});

test('boxes come back from base64 and in metres', () => {
  const boxes = decode_boxes({ origin: [-1, -2, 0.5], unit: 0.5, boxes: 'AQACAAMAAgEFAP//' });
  assert.deepEqual([...boxes.data], [1, 2, 3, 258, 5, 65535]);
  assert.deepEqual(data_hull(boxes), [-0.5, -1, 2, 128, 0.5, 32768]);
  assert.deepEqual(hull([[0, 0, 0, 1, 1, 1], [-1, 0.5, 0, 0, 3, 0.5]]), [-1, 0, 0, 1, 3, 1]);
  assert.equal(hull([]), null);
});

test('density keeps the volume when it fits and the proportions when it must coarsen', () => {
  const fine = density_grid(Uint16Array.of(3, 3, 3, 5, 6, 7), 1);
  assert.equal(fine.cell, 1);
  assert.equal(fine.values.reduce((sum, value) => sum + value, 0), 2 * 3 * 4 * 255);
  const coarse = density_grid(Uint16Array.of(0, 0, 0, 1000, 1, 1), 2);
  assert.ok(coarse.counts[0] <= 256 && coarse.cell === 4);
  assert.equal(coarse.values[0], 16);  // a row of 4 in a cell of 64, in 255ths
});

test('numbers read well and never throw', () => {
  assert.equal(fixed(-1.005, 2), '−1.00');
  assert.equal(fixed(-0.001, 2), '0.00');
  assert.equal(fixed(null, 2), '–');
  assert.equal(significant(-2.1e-9), '−2.1 × 10⁻⁹');
  assert.equal(significant(0), '0');
  assert.equal(significant(undefined), '–');
  assert.deepEqual([12.5, 1834.2, 2.5e6, null].map((time) => Object.values(time_span(time)).join(' ')), ['12.5 µs', '1.83 ms', '2.5 s', '– ']);
});

test('ticks are round and inside the range', () => {
  assert.deepEqual(ticks(-0.3, 1.1, 3), [0, 0.5, 1]);
  assert.deepEqual(ticks(0, 32.15, 5), [0, 10, 20, 30]);
});

test('text of the data is escaped, markup of our own is not', () => {
  assert.equal(html`<b>${'<i>&'}</b>${html`<u>${1}</u>`}${null}${[false, 'x']}`.text, '<b>&#60;i&#62;&#38;</b><u>1</u>x');
  assert.ok(!plan_numbers(plan, null).text.includes('<small> &'));
});

test('the speed scale ends at its own colours and rises in lightness', () => {
  const lightness = ([r, g, b]) => 0.2126 * r + 0.7152 * g + 0.0722 * b;
  const steps = Array.from({ length: 21 }, (_, i) => lightness(speed_colour(i / 20)));
  assert.ok(steps.every((value, i) => i === 0 || value > steps[i - 1]));
  assert.deepEqual(speed_colour(-1), speed_colour(0));
  assert.deepEqual(speed_colour(2), speed_colour(1));
});

test('a plan has twelve panels whose readout agrees with their curve', () => {
  const panels = plan_panels(plan, new Trajectory(plan.segments));
  assert.equal(panels.length, 12);
  for (const panel of panels) {
    for (const [t, value] of panel.line.filter(([time]) => time !== 2)) assert.equal(panel.at(t), value, panel.title);
  }
});

test('limits per axis belong to the axes, Euclidean ones to the norm', () => {
  const limits_of = (request) => plan_panels({ ...plan, request }, new Trajectory(plan.segments)).map((panel) => panel.limits);
  assert.deepEqual(limits_of(plan.request)[4], [-1, 1]);
  assert.deepEqual(limits_of(plan.request)[7], []);
  assert.deepEqual(limits_of({ ...plan.request, norm: 'euclidean' })[11], [1.5]);
});

test('a panel draws its line, its limits and the box of each moment inside the frame', () => {
  const panel = plan_panels(plan, new Trajectory(plan.segments))[0];
  const svg = plot_svg(panel, options);
  const heights = [...svg.matchAll(/points="([^"]*)"/g)].flatMap((match) => match[1].split(' ').map((point) => Number(point.split(',')[1])));
  assert.equal((svg.match(/<polyline/g) ?? []).length, 1);
  assert.ok(svg.includes('class="band"'));
  assert.ok(heights.every((y) => y >= 0 && y <= options.height));
});

test('the range of a panel holds its limits, even for a flat line', () => {
  const [low, high] = value_range({ line: [[0, 0], [4, 0]], limits: [-1, 1] });
  assert.ok(low < -1 && high > 1);
  const flat = value_range({ line: [[0, 3], [4, 3]] });
  assert.ok(flat[0] < 3 && flat[1] > 3);
});

test('every status has its page, fields or not', () => {
  const statuses = ['optimal', 'fallback', 'start_not_free', 'goal_not_free', 'no_path', 'search_capacity', 'corridor_capacity',
                    'infeasible', 'bad_request', 'something_new'];
  for (const status of statuses) {
    const bare = { status, blocking: { box: 3, axis: 'x', bound: 'upper', missing: 0.25, stretch: null } };
    assert.ok(plan_heading('t', bare).text.includes(status.replace(/_/g, ' ')));
    assert.ok(headline(bare).text.includes('–'));
    assert.ok(plan_numbers(bare, null).text.includes('0.25'));
  }
});

test('a line is interrupted where it has no value, and does not widen the range there', () => {
  const panel = { title: 't', line: [[0, NaN], [1, 1], [2, 2], [3, NaN], [3, NaN], [4, 1]], limits: [], colour: 'whole', least: 0 };
  const lines = [...plot_svg(panel, options).matchAll(/<polyline[^>]*points="([^"]*)"/g)].map((match) => match[1].split(' ').length);
  assert.deepEqual(lines, [2, 1]);
  const [low, high] = value_range(panel);
  assert.ok(low < 0 && low > -1 && high > 2 && high < 3);
  assert.deepEqual(value_range({ line: [[0, NaN]] }), [0, 1]);
});

const pack = (integers) => Buffer.from(Uint16Array.from(integers.flat()).buffer).toString('base64');

/// Four moments: 1 m along x within 2 s, turning from 170 to -170 degrees, at last upside down; the reference begins with
/// the second one.
function small_flight(flight = {}) {
  const channel = (low, step, integers) => ({ low, step, values: pack(integers) });
  const none = channel(0, 1, [65535, 65535, 65535, 65535]);
  const unit = (values) => channel(-1, 1 / 32767, values.map((value) => Math.round(32767 * (value + 1))));
  const [far, near] = [Math.sin((85 * Math.PI) / 180), Math.cos((85 * Math.PI) / 180)];
  return {
    kind: 'flight', title: 't', vehicle_radius: 0.2, tracking_tube: 0.1, speed_limit: 1, speed_limit_per_axis: true, line_rate: 1000,
    goals: [[1, 0, 0], [2, 0, 0]], phases: [{ t: 0, name: 'mission' }], states: [{ t: 0, name: 'holding' }, { t: 1, name: 'flying' }],
    events: [{ t: 1, kind: 'note', what: 'a <plan>' }, { t: 2, kind: 'arrival', what: 'goal 1 reached' }],
    plans: { count: 1, shown: [{ number: 1, committed: 1, begins: 1, duration: 9, length: 1, boxes: [[0, 0, 0, 1, 1, 1]], path: {} }] },
    flight,
    samples: {
      count: 4, shown: 4, t: { low: pack([0, 1000, 2000, 34464]), high: pack([0, 0, 0, 1]) },
      x: channel(-1, 0.5, [0, 1, 2, 2]), y: channel(0, 1, [0, 0, 0, 0]), z: channel(1, 1, [0, 0, 0, 0]),
      reference_x: channel(-1, 0.5, [65535, 1, 2, 2]), reference_y: channel(0, 1, [65535, 0, 0, 0]), reference_z: channel(1, 1, [65535, 0, 0, 0]),
      qw: unit([near, near, 1, 0]), qx: unit([0, 0, 0, 1]), qy: unit([0, 0, 0, 0]), qz: unit([far, -far, 0, 0]),
      tracking_error: channel(0, 0.01, [65535, 2, 4, 20]), estimate_error: none, speed: channel(0, 1, [0, 1, 0, 0]), reference_speed: none,
      setpoint_rate: channel(0, 1, [50, 50, 50, 50]), rate_in: channel(0, 1, [100, 100, 100, 200]), rate_out: none,
    },
  };
}

test('a packed channel gives its values, and none where there is none', () => {
  assert.deepEqual([...decode_channel({ low: -1, step: 0.5, values: pack([0, 3, 65534, 65535]) })], [-1, 0.5, 32766, NaN]);
});

test('the last of ascending times is found, before, between, at and after them', () => {
  assert.deepEqual([-1, 0, 0.5, 1, 2, 9].map((t) => last_at([0, 1, 1, 2], t)), [-1, 0, 0, 2, 3, 3]);
  assert.equal(last_at([], 1), -1);
  assert.deepEqual(spans([{ t: 0, name: 'a' }, { t: 2, name: 'b' }], 5).map(({ t, end }) => [t, end]), [[0, 2], [2, 5]]);
});

test('a flight is looked up by time, between its samples and beyond its ends', () => {
  const track = new FlightTrack(small_flight().samples);
  assert.equal(track.duration, 100);
  assert.equal(track.length, 1);
  assert.deepEqual([-1, 0.5, 1.5, 50, 999].map((t) => track.position(t)[0]), [-1, -0.75, -0.25, 0, 0]);
  assert.equal(track.reference(0.5), null);
  assert.deepEqual(track.reference(1.5), [-0.25, 0, 1]);
  assert.deepEqual([0, 1, 2].map((t) => Math.round(track.value('heading', t))), [170, -170, 0]);
  assert.deepEqual([0, 2, 100].map((t) => Math.round(track.value('tilt', t))), [0, 0, 180]);
  assert.deepEqual([0, 1, 2, 3].map((t) => track.value('speed', t)), [0, 1, 0, 0]);
});

test('an attitude between two samples goes the near way and stays a rotation', () => {
  const track = new FlightTrack(small_flight().samples);
  const [x, y, z, w] = track.attitude(0.5);
  assert.ok(Math.abs(Math.hypot(x, y, z, w) - 1) < 1e-12);
  assert.ok(Math.abs(w) < 1e-3 && Math.abs(z) > 0.999, 'half-way from 170 to -170 degrees is 180, not 0');
});

test('a thinned curve keeps extremes and gaps, a thinned path its ends', () => {
  const values = Array.from({ length: 1000 }, (_, i) => (i >= 500 && i < 700 ? 65535 : i === 123 ? 900 : i % 7));
  const flat = pack(Array(1000).fill(0));
  const zero = { low: 0, step: 1, values: flat };
  const names = ['x', 'y', 'z', 'qw', 'qx', 'qy', 'qz'];
  const track = new FlightTrack({ count: 1000, shown: 1000, t: { low: pack(values.map((_, i) => i)), high: flat }, ...Object.fromEntries(names.map((name) => [name, zero])), speed: { low: 0, step: 1, values: pack(values) } });
  const curve = track.curve('speed', 100);
  assert.ok(curve.length <= 100);
  assert.equal(Math.max(...curve.map(([, value]) => value).filter(Number.isFinite)), 900);
  assert.ok(curve.some(([t, value]) => t >= 0.5 && t < 0.7 && Number.isNaN(value)));
  assert.ok(curve.every(([t], i) => i === 0 || t >= curve[i - 1][0]));
  assert.deepEqual(track.path(0.1), [0, 999]);
});

test('a flight has nine panels, with the tube, the limit and the load of the line', () => {
  const report = small_flight();
  const track = new FlightTrack(report.samples);
  const panels = flight_panels(report, track);
  assert.equal(panels.length, 9);
  assert.deepEqual([panels[0].limits, panels[1].limits], [[10], [1]]);
  assert.equal(panels[0].at(2), 4);
  assert.equal(panels[8].at(100), 20);
  assert.ok(panels[4].line.some(([, value]) => Number.isNaN(value)), 'a turn through south breaks the heading');
  for (const panel of panels) assert.ok(!plot_svg(panel, { ...options, duration: 100 }).includes('NaN'), panel.title);
  const bare = { ...report, tracking_tube: null, speed_limit: null, line_rate: null };
  assert.equal(tracking_top(bare, track), 0.2);
  assert.deepEqual(flight_panels(bare, track).slice(0, 2).map((panel) => panel.limits), [[], []]);
});

test('the timeline shows states, phases and events, and leads from event to event', () => {
  const report = small_flight();
  const text = timeline_markup({ ...report, duration: 100, states: spans(report.states, 100), phases: spans(report.phases, 100) }).text;
  for (const part of ['state-flying', 'left:1.000%;width:99.000%', 'a &#60;plan&#62;', 'class="event arrival"', 'aria-label="Time of the flight [s]"']) assert.ok(text.includes(part), part);
  assert.deepEqual([0, 1, 2, 3].map((t) => neighbour_event(report.events, t, 1)), [1, 2, null, null]);
  assert.deepEqual([0, 1, 2, 3].map((t) => neighbour_event(report.events, t, -1)), [null, null, 1, 2]);
});

test('a flight has its page, fields or not', () => {
  const bare = small_flight();
  assert.ok(flight_heading('t', bare).text.includes('unknown'));
  assert.ok(flight_headline(bare).text.includes('–'));
  assert.ok(flight_numbers({ ...bare, track_length: 1 }).text.includes('Way flown'));
  assert.ok(event_list([]).text.includes('Nothing'));
  const full = small_flight({
    status: 'pilot_took_over', reason: 'the <pilot>', tracking: { rms: 0.03, max: 0.11 }, flown_clearance: 0.15, flown_duration: 12.3, link: { messages_in: 12345, crc_errors: 2, load_in: 0.125 },
    request: { start: [0, 0, 1], setpoint: 'rates', vmax: 1, gust: 3, seed: 7, in_process: true }, margins: { map_radius: 0.3 }, setpoints: { count: 50, jitter_p99: 0.002 },
    plans: [{ id: 1, total_us: 812 }], faults: [{ fault: 'stall@3', t: 3, after: 0.25, what: 'braking', settled: null }],
  });
  assert.ok(flight_heading('t', full).text.includes('pilot took over'));
  const text = flight_headline(full).text + flight_numbers({ ...full, track_length: 1 }).text;
  for (const part of ['3.0', 'figure bad', '12.3', '12,345', '12.5', 'rates', '812 µs', 'stall@3', '0.250', 'lock-step', '2 <small>ms']) assert.ok(text.includes(part), part);
  assert.ok(flight_numbers({ ...full, plans: { ...full.plans, count: 9 } }).text.includes('8 more'));
});

/// Two cells with a window of 1 m x 2 m and a third cell apart, on a grid of half metres.
function small_map() {
  const boxes = [[0, 0, 2, 4, 4, 6], [4, 2, 2, 6, 4, 6], [10, 0, 2, 12, 2, 4]];
  return {
    grid: { origin: [-1, 0, 1], unit: 0.5, voxel: 0.5 },
    cells: { count: 3, shown: 3, shown_share: 1, boxes: pack(boxes), extents: pack([boxes[0], [0, 2, 2, 6, 4, 6], boxes[2]]), components: pack([0, 0, 7]) },
    windows: { count: 1, shown: 1 },
    components: [{ label: 0, cells: 2, free_m3: 10, share: 10 / 11 }, { label: 7, cells: 1, free_m3: 1, share: 1 / 11 }],
    map: {},
  };
}

test('a cell is found by a point in it, by a line of sight and by a height', () => {
  const map = new CellMap(small_map());
  assert.deepEqual([[0, 1, 3], [1.5, 1.5, 3], [1.5, 0.5, 3], [4.5, 0.5, 2.5], [4.5, 0.5, 3.5]].map((p) => map.at(p)), [0, 1, -1, 2, -1]);
  assert.deepEqual(first_hit(map.cells, [-3, 0.5, 2.5], [1, 0, 0], [0, 9]), { index: 0, distance: 2 });
  assert.deepEqual(first_hit(map.cells, [4.5, 0.5, 9], [0, 0, -1], [0, 9]), { index: 2, distance: 6 });
  assert.equal(first_hit(map.cells, [4.5, 0.5, 9], [0, 0, -1], [3.5, 9]), null);
  assert.equal(first_hit(map.cells, [-3, 9, 2.5], [1, 0, 0], [0, 9]), null);
  assert.deepEqual(boxes_across(map.cells, 5, 5), [0, 1]);
  assert.equal(widest_height(map.cells), 2.5);
});

test('a cell knows its extent and its windows', () => {
  const map = new CellMap(small_map());
  assert.deepEqual(map.windows(0), [[1, 1, 2, 1, 2, 4]]);
  assert.deepEqual(map.windows(2), []);
  assert.deepEqual(map.extent(1), [-1, 1, 2, 2, 2, 4]);
  assert.ok(cell_line(map, 0).text.includes('2.00 × 2.00 × 2.00 m in component 0, with 1 window '));
});

test('cells are coloured by component, by volume, and without harm when all are alike', () => {
  const map = new CellMap(small_map());
  const cell = (colours, i) => [...colours.slice(3 * i, 3 * i + 3)];
  const by_component = map.colours('component');
  assert.deepEqual(cell(by_component, 0), cell(by_component, 1));
  assert.notDeepEqual(cell(by_component, 0), cell(by_component, 2));
  const by_volume = map.colours('volume');
  assert.deepEqual(cell(by_volume, 2), speed_colour(0).map((channel) => Math.round(255 * channel)));
  assert.deepEqual(cell(by_volume, 0), speed_colour(1).map((channel) => Math.round(255 * channel)));
  const none = { ...small_map(), cells: { boxes: '', extents: '', components: '' }, components: [] };
  assert.equal(new CellMap(none).colours('volume').length, 0);
});

test('a map has its page, fields or not', () => {
  const report = small_map();
  assert.ok(map_headline({}).text.includes('–'));
  assert.ok(map_heading('t', {}, '').text.includes('nothing free'));
  assert.ok(map_heading('t', { cells: 3, largest_component: 0.89 }, 'why').text.includes('in pieces'));
  assert.ok(map_heading('t', { cells: 3, largest_component: 0.9 }, '').text.includes('connected'));
  assert.ok(!map_numbers(report).text.includes('largest first'));
  report.cells = { ...report.cells, count: 12345 };
  report.map = { components: 3, section_bytes: { record_offsets: 1234 } };
  report.map.boards = [{ name: 'tiny', map_bytes: 2e6, holds_map: false, search_nodes: 1500, search_share: 0.25 }];
  const text = map_numbers(report).text;
  for (const part of ['tiny', 'too small', '2.00 MB', '1,500 (25.0 %)', 'largest first', 'record offsets', '1,234', 'and 1 smaller one', '90.91 %']) assert.ok(text.includes(part), part);
});
