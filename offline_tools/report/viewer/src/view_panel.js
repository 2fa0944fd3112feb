import { fixed, html } from './markup.js';

// The controls over the 3-D view: layers, a band of heights, directions.

/// `layers` are { name, text, colour, on }; `heights` is [low, high] in metres and `shown` the band at the start; `more`
/// is markup for beneath the directions.
export function panel_markup(layers, heights, shown, more) {
  const step = Math.max((heights[1] - heights[0]) / 400, 1e-3);
  const handle = (name, value) => html`<input type="range" name="${name}" aria-label="${name} height shown [m]"
    min="${heights[0]}" max="${heights[1]}" step="${step}" value="${value}">`;
  return html`<div class="panel">
    <div class="directions" role="group" aria-label="View">${['oblique', 'top', 'side'].map((name) =>
      html`<button type="button" data-direction="${name}">${name}</button>`)}</div>${more}
    <div class="layers">${layers.map((layer) => html`<label><input type="checkbox" name="${layer.name}" ${layer.on ? 'checked' : ''}>
      <i style="background:${layer.colour}"></i>${layer.text}</label>`)}</div>
    <fieldset class="heights"><legend>Heights <output></output></legend><div class="band">${handle('lowest', shown[0])}${
      handle('highest', shown[1])}</div></fieldset>
  </div>`;
}

/// Connects the controls in `host` to the view; `framed` is the box that the direction buttons look at.
export function connect_panel(host, view, framed) {
  host.querySelectorAll('.layers input').forEach((input) => {
    const show = () => view.show(input.name, input.checked);
    input.addEventListener('change', show);
    show();
  });
  host.querySelectorAll('[data-direction]').forEach((button) => {
    button.addEventListener('click', () => view.fit(framed, button.dataset.direction));
  });
  connect_heights(host.querySelector('.heights'), view);
}

function connect_heights(fieldset, view) {
  const [low, high] = fieldset.querySelectorAll('input');
  const readout = fieldset.querySelector('output');
  const band = fieldset.querySelector('.band');
  const update = () => {
    const values = [Number(low.value), Number(high.value)];
    const share = (value) => (value - low.min) / (low.max - low.min);
    band.style.setProperty('--from', share(values[0]));
    band.style.setProperty('--to', share(values[1]));
    readout.textContent = `${fixed(values[0], 2)} to ${fixed(values[1], 2)} m`;
    view.slice(values[0], Number(high.value) >= Number(high.max) - 1e-9 ? 1e9 : values[1]);
  };
  low.addEventListener('input', () => {
    low.value = Math.min(low.value, high.value);
    update();
  });
  high.addEventListener('input', () => {
    high.value = Math.max(low.value, high.value);
    update();
  });
  update();
}
