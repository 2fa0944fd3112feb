import { card, figure, file_name, row } from './cards.js';
import { kComponentColours } from './colours.js';
import { count, fixed, html, significant, vector } from './markup.js';

// The numbers of a swiftlet-map/1 as markup. Every field may be absent.

const kGoodShare = 0.9;  // of the free space in the largest component
const kUnknown = { avoid: 'avoided', occupied: 'an obstacle', free: 'free' };

function percent(share, digits = 1) {
  return typeof share === 'number' ? `${fixed(100 * share, digits)} %` : '–';
}

/// Kilobytes or megabytes, as they read best.
function size_of(bytes) {
  if (typeof bytes !== 'number') return { value: '–', unit: '' };
  return bytes < 1e6 ? { value: fixed(bytes / 1e3, 1), unit: 'kB' } : { value: fixed(bytes / 1e6, 2), unit: 'MB' };
}

/// How the free space hangs together, in a word.
function state_of(map) {
  if (!map.cells) return { tone: 'bad', text: 'nothing free' };
  if (map.largest_component < kGoodShare) return { tone: 'fair', text: 'in pieces' };
  return { tone: 'good', text: 'connected' };
}

export function map_heading(title, map, note) {
  const state = state_of(map);
  const vehicle = html`Free space for a vehicle of radius ${significant(map.radius_m)} m, unknown space ${kUnknown[map.unknown] ?? map.unknown ?? '–'}.`;
  return html`<div><h1>${title}</h1><p>${vehicle}</p>${note && html`<p class="note">${note}</p>`}</div><span class="pill ${state.tone}">${state.text}</span>`;
}

export function map_headline(map) {
  const blob = size_of(map.blob_bytes);
  const { tone } = state_of(map);
  return html`<dl class="headline">
    ${figure('Free', significant(map.free_m3), 'm³')}
    ${figure('Cells', count(map.cells), '')}
    ${figure('Windows', count(map.windows), '')}
    ${figure('Components', count(map.components), '')}
    ${figure('Largest component', percent(map.largest_component), '', tone === 'good' ? '' : tone)}
    ${figure('Blob', blob.value, blob.unit)}
  </dl>`;
}

function source_card(map) {
  const bounds = Array.isArray(map.bounds) ? map.bounds : [];
  return card('Source', [
    row('File', map.source?.startsWith('sha256:') ? `${map.source.slice(0, 17)}…` : file_name(map.source)),
    row('CRC-32 of the blob', map.crc32 ?? '–'),
    row('Low corner', vector(bounds.slice(0, 3), 2), 'm'),
    row('High corner', vector(bounds.slice(3), 2), 'm'),
    row('Resolution', significant(map.resolution_m), 'm'),
    row('Stored in steps of', significant(map.unit_m), 'm'),
    row('Vehicle radius', significant(map.radius_m), 'm'),
    row('Unknown space', map.unknown ?? '–'),
  ]);
}

function space_card(map) {
  return card('Space', [
    row('Free', significant(map.free_m3, 6), 'm³'),
    row('Lost to inflation', significant(map.lost_to_inflation_m3, 6), 'm³'),
    row('Lost to unknown space', significant(map.lost_to_unknown_m3, 6), 'm³'),
    row('Lost to coarsening', significant(map.lost_to_coarsening_m3, 6), 'm³'),
    row('Lost to slivers', significant(map.lost_to_slivers_m3, 6), 'm³'),
    row('Worst loss by quantisation', significant(map.worst_loss_m, 3), 'm'),
  ]);
}

/// How many of a kind the page holds, when those are not all.
function shown_row({ count: all, shown }) {
  return shown < all && row('shown, largest first', count(shown));
}

function graph_card({ map, cells, windows, obstacles }) {
  return card('Graph', [
    row('Cells', count(map.cells)),
    shown_row(cells),
    cells.shown < cells.count && row('which hold, of the free space', percent(cells.shown_share)),
    row('Windows', count(map.windows)),
    shown_row(windows),
    row('Windows of a cell, mean', significant(map.degree?.mean, 3)),
    row('at most', count(map.degree?.max)),
    row('Obstacle boxes', obstacles ? count(obstacles.count) : '–'),
    obstacles && shown_row(obstacles),
  ]);
}

function bytes_card(map) {
  const sections = Object.entries(map.section_bytes ?? {});
  return card('Bytes', [
    ...sections.map(([name, bytes]) => row(name.replace(/_/g, ' '), count(bytes))),
    row(html`<b>Blob</b>`, html`<b>${count(map.blob_bytes)}</b>`),
  ]);
}

function boards_card(map) {
  if (!map.boards?.length) return null;
  const reach = ({ search_nodes: nodes, search_share: share }) => (share < 1 ? `${count(nodes)} (${percent(share)})` : 'all');
  const rows = map.boards.map((board) => html`<tr><td>${board.name}</td><td>${board.holds_map ? 'holds it' : 'too small'}</td>
    <td>${size_of(board.map_bytes).value} ${size_of(board.map_bytes).unit}</td><td>${reach(board)}</td></tr>`);
  return html`<section class="card wide"><h3>Boards</h3><div class="scroll"><table class="list">
    <thead><tr><th>board</th><th>the map</th><th>memory for maps</th><th>windows that a search may reach</th></tr></thead>
    <tbody>${rows}</tbody></table></div></section>`;
}

function components_card(map, components) {
  if (!components.length) return null;
  const rows = components.map(({ label, cells, free_m3, share }, rank) => html`<tr><td><i class="swatch" style="background:${kComponentColours[rank]}"></i>${label}</td>
    <td>${count(cells)}</td><td>${significant(free_m3)}</td><td>${percent(share, 2)}</td>
    <td><meter min="0" max="1" value="${share.toFixed(4)}"></meter></td></tr>`);
  const rest = map.components - components.length;
  return html`<section class="card wide"><h3>Components</h3><div class="scroll"><table class="list">
    <thead><tr><th>component</th><th>cells</th><th>free [m³]</th><th>of all free space</th><th></th></tr></thead>
    <tbody>${rows}</tbody></table></div>${rest > 0 && html`<p>and ${count(rest)} smaller ${rest === 1 ? 'one' : 'ones'}</p>`}</section>`;
}

export function map_numbers(report) {
  const { map, components } = report;
  return html`<div class="cards">${source_card(map)}${space_card(map)}${graph_card(report)}${bytes_card(map)}${boards_card(map)}${components_card(map, components)}</div>`;
}

/// What there is to say about the chosen cell, in one line, with the colours in which it is drawn.
export function cell_line(map, i) {
  const size = (box) => [0, 1, 2].map((axis) => fixed(box[axis + 3] - box[axis], 2)).join(' × ');
  const windows = map.windows(i).length;
  return html`<i class="swatch" style="background:var(--gate)"></i>Cell of ${size(map.box(i))} m in component ${map.labels[i]}, with ${
      count(windows)} ${windows === 1 ? 'window' : 'windows'} to the cells shown <i class="swatch" style="background:var(--ink)"></i>its extent of ${size(map.extent(i))} m`;
}
