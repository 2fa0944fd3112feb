// Which curves of a flight are worth a panel: how well it was flown, how, and over which link.

const kMostPoints = 1600;

/// `other`, if any, names the channel that is drawn beneath.
function panel(track, name, { other, scale = 1, ...description }) {
  const curve = (channel) => track.curve(channel, kMostPoints).map(([t, value]) => [t, scale * value]);
  const line = curve(name);
  return { ...description, line, other: other && curve(other), at: (t) => scale * track.value(name, t) };
}

/// A heading that turns through north-south jumps by a full turn: the line is broken there.
function broken_at_turns(line) {
  return line.flatMap(([t, value], i) => (i > 0 && Math.abs(value - line[i - 1][1]) > 180 ? [[t, NaN], [t, value]] : [[t, value]]));
}

/// Nine panels in three rows of three.
export function flight_panels(report, track) {
  const tube = report.tracking_tube;
  const heading = panel(track, 'heading', { title: 'heading from east', unit: '°', digits: 1, colour: 'axis-z' });
  return [
    panel(track, 'tracking_error', { title: 'tracking error', unit: 'cm', digits: 1, colour: 'scale', top: 100 * tracking_top(report, track), scale: 100, least: 0,
                                     limits: tube ? [100 * tube] : [], band: tube ? [[0, track.duration, 0, 100 * tube]] : undefined }),
    panel(track, 'speed', { title: report.speed_limit_per_axis ? 'speed, fastest axis' : 'speed', unit: 'm/s', digits: 2, colour: 'whole', least: 0,
                            other: 'reference_speed', limits: report.speed_limit ? [report.speed_limit] : [] }),
    panel(track, 'z', { title: 'height', unit: 'm', digits: 2, colour: 'axis-z', other: 'reference_z' }),
    panel(track, 'tilt', { title: 'tilt', unit: '°', digits: 1, colour: 'axis-x', least: 0 }),
    { ...heading, line: broken_at_turns(heading.line) },
    panel(track, 'estimate_error', { title: 'error of the estimate', unit: 'cm', digits: 1, colour: 'axis-y', scale: 100, least: 0 }),
    panel(track, 'setpoint_rate', { title: 'set-points', unit: 'Hz', digits: 1, colour: 'whole', least: 0 }),
    load_panel(report, track, 'rate_out', 'link, sent'),
    load_panel(report, track, 'rate_in', 'link, received'),
  ];
}

/// As a share of what the line carries, where that is known.
function load_panel({ line_rate }, track, name, title) {
  const [scale, unit] = line_rate ? [100 / line_rate, '% of the line'] : [1e-3, 'kB/s'];
  return panel(track, name, { title, unit, scale, digits: 2, colour: 'whole', least: 0 });
}

/// The tracking error [m] at the end of the colour scale: the tube, or the largest that was.
export function tracking_top(report, track) {
  if (report.tracking_tube > 0) return report.tracking_tube;
  return track.tracking_error.reduce((most, error) => (error > most ? error : most), 0.01);
}
