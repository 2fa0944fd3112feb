// The parts of the viewer that need no browser: node --test test/viewer.test.js
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import test from 'node:test';

import { data_hull, decode_boxes, hull } from '../src/boxes_data.js';
import { boxes_across, CellMap, first_hit, widest_height } from '../src/cell_map.js';
import { speed_colour } from '../src/colours.js';
import { density_grid } from '../src/density.js';
import { fixed, html, significant, time_span } from '../src/markup.js';
import { cell_line, map_heading, map_headline, map_numbers } from '../src/map_numbers.js';
import { headline, plan_heading, plan_numbers } from '../src/numbers.js';
import { plan_panels } from '../src/plan_plots.js';
import { plot_svg, value_range } from '../src/plots.js';
import { ticks } from '../src/ticks.js';
import { box_margin, evaluate, Trajectory } from '../src/trajectory.js';

const plan = JSON.parse(readFileSync(new URL('../../../../tests/data/plan_small.json', import.meta.url)));
const options = { duration: 4, junctions: [2], width: 300, height: 150, top_speed: 0.9375, id: 'speed' };

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

/// Two cells with a window of 1 m x 2 m and a third cell apart, on a grid of half metres.
function small_map() {
  const pack = (integers) => Buffer.from(Uint16Array.from(integers.flat()).buffer).toString('base64');
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
