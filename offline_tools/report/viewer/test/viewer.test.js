// The parts of the viewer that need no browser: node --test test/viewer.test.js
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import test from 'node:test';

import { data_hull, decode_boxes, hull } from '../src/boxes_data.js';
import { speed_colour } from '../src/colours.js';
import { density_grid } from '../src/density.js';
import { fixed, html, significant, time_span } from '../src/markup.js';
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
