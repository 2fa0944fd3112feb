import { html } from './markup.js';

// The pieces that the numbers of every page are made of.

export function file_name(path) {
  return typeof path === 'string' ? path.split(/[\\/]/).pop() : '–';
}

/// One of the few figures in large type.
export function figure(label, value, unit, tone) {
  return html`<div class="figure ${tone ?? ''}"><dt>${label}</dt><dd>${value}${value !== '–' && unit && html`<small>${unit}</small>`}</dd></div>`;
}

export function row(label, value, unit) {
  return html`<tr><th>${label}</th><td>${value}${unit && html` <small>${unit}</small>`}</td></tr>`;
}

export function card(title, rows) {
  return html`<section class="card"><h3>${title}</h3><table class="pairs">${rows}</table></section>`;
}
