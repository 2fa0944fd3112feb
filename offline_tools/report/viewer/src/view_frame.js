import { kSpeedGradient } from './colours.js';
import { html } from './markup.js';
import { ball } from './path_tube.js';
import { View } from './scene.js';

// What every page has around its 3-D view.

/// `heading` says what the page shows.
export function header_markup(version, heading) {
  return html`<header><a class="brand">swiftlet <small>${version}</small></a>${heading}
      <button type="button" class="theme" aria-label="Light or dark" title="Light or dark"></button></header>`;
}

/// The view in `host`; null, and a word instead of it, without WebGL.
export function open_view(host) {
  try {
    return new View(host);
  } catch (error) {
    host.classList.add('missing');
    host.innerHTML = html`<p>The 3-D view needs WebGL 2, which this browser does not offer. Everything else is below.</p>`.text;
    return null;
  }
}

/// Box `flown` with its surroundings: as far again to every side as half its longest edge, within box `all`.
export function surroundings(flown, all) {
  const reach = Math.max(flown[3] - flown[0], flown[4] - flown[1], flown[5] - flown[2], 2) / 2;
  return all.map((bound, i) => (i < 3 ? Math.max(bound, flown[i] - reach) : Math.min(bound, flown[i] + reach)));
}

/// What lies above the flight is cut off at the start, so that the page opens with a look into the building.
export function band_at_start(flown, all) {
  const above = flown ? flown[5] + 0.02 * (all[5] - all[2]) : all[5];
  return [all[2], Math.min(above, all[5])];
}

/// A ball with a caption; `kind` is 'start' or 'goal'.
export function add_mark(view, name, text, position, { radius, kind }) {
  view.add(name, ball(position, { radius, least: 0.005, colour: `--${kind}`, opacity: 0.95 }));
  view.label(text, position, `end ${kind}`, name);
}

/// The colours from 0 to `top`.
export function legend_markup(what, top) {
  return html`<div class="legend"><span>${what}</span><b>0</b><i style="background:${kSpeedGradient}"></i><b>${top}</b></div>`;
}
