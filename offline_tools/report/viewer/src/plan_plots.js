import { box_margin, kAxes, norm } from './trajectory.js';

// Which curves of a plan are worth a panel: per axis and as a whole, position, velocity, acceleration.

/// The limits that bind one quantity of one axis: what the optimiser was given, on both sides.
function axis_limits(bounds, axis) {
  const bound = bounds?.[axis];
  return typeof bound === 'number' ? [-bound, bound] : [];
}

function panel(samples, trajectory, value, description) {
  return { ...description, line: samples.map((sample) => [sample.t, value(sample)]), at: (t) => value(trajectory.sample(t)) };
}

function axis_panels(plan, trajectory, samples) {
  const rows = [
    { name: '', key: 'position', unit: 'm' },
    { name: 'v', key: 'velocity', unit: 'm/s', bounds: plan.qp?.vmax },
    { name: 'a', key: 'acceleration', unit: 'm/s²', bounds: plan.qp?.amax },
  ];
  return rows.map((row) => kAxes.map((axis, i) => panel(samples, trajectory, (sample) => sample[row.key][i], {
    title: row.name ? `${row.name} ${axis}` : axis,
    unit: row.unit,
    colour: `axis-${axis}`,
    limits: axis_limits(row.bounds, i),
    band: row.key === 'position' ? box_band(plan, trajectory, i) : undefined,
  })));
}

/// The extent of the box in force along one axis, segment by segment.
function box_band(plan, trajectory, axis) {
  return plan.corridor?.map((box, i) => [trajectory.starts[i], trajectory.starts[i + 1], box[axis], box[axis + 3]]);
}

function norm_limit(request, limit) {
  return request?.norm === 'euclidean' && typeof limit === 'number' ? [limit] : [];
}

/// Twelve panels in three rows of four: x, y, z and the whole, for position, velocity and acceleration. `top_speed` is
/// at the end of the colours.
export function plan_panels(plan, trajectory, top_speed) {
  const samples = trajectory.samples(600);
  const [position, velocity, acceleration] = axis_panels(plan, trajectory, samples);
  const margin = panel(samples, trajectory, (sample) => box_margin(plan.corridor[sample.index], sample.position),
                       { title: 'distance to the box', unit: 'm', colour: 'whole', limits: [0] });
  const speed = panel(samples, trajectory, (sample) => norm(sample.velocity),
                      { title: 'speed', unit: 'm/s', colour: 'scale', top: top_speed, limits: norm_limit(plan.request, plan.request?.vmax) });
  const effort = panel(samples, trajectory, (sample) => norm(sample.acceleration),
                       { title: 'acceleration', unit: 'm/s²', colour: 'whole', limits: norm_limit(plan.request, plan.request?.amax) });
  return [...position, margin, ...velocity, speed, ...acceleration, effort];
}
