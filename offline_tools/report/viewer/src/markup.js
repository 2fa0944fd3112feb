// Markup as strings: every page part is a pure function from data to text, so it is tested without a browser.

export function escape_html(value) {
  return String(value).replace(/[&<>"']/g, (character) => `&#${character.charCodeAt(0)};`);
}

/// Text that is already markup; everything else that enters an `html` template is escaped.
export class Markup {
  constructor(text) {
    this.text = text;
  }
  toString() {
    return this.text;
  }
}

function render(value) {
  if (value === null || value === undefined || value === false) return '';
  if (value instanceof Markup) return value.text;
  if (Array.isArray(value)) return value.map(render).join('');
  return escape_html(value);
}

export function html(strings, ...values) {
  return new Markup(strings.reduce((text, part, i) => text + render(values[i - 1]) + part));
}

const kMissing = '–';

/// A number with `digits` decimals and a true minus sign; a dash for null or a missing one.
export function fixed(value, digits) {
  if (typeof value !== 'number' || !Number.isFinite(value)) return kMissing;
  const text = value.toFixed(digits);
  return (Number(text) === 0 ? text.replace('-', '') : text).replace('-', '−');
}

function superscript(integer) {
  return [...String(integer)].map((character) => '⁻⁰¹²³⁴⁵⁶⁷⁸⁹'['-0123456789'.indexOf(character)]).join('');
}

/// A number with `digits` significant digits, tiny and huge ones as a power of ten.
export function significant(value, digits = 4) {
  if (typeof value !== 'number' || !Number.isFinite(value)) return kMissing;
  const size = Math.abs(value);
  if (size !== 0 && (size < 1e-3 || size >= 1e7)) {
    const [mantissa, exponent] = value.toExponential(Math.min(digits, 3) - 1).split('e');
    return `${Number(mantissa)} × 10${superscript(Number(exponent))}`.replace('-', '−');
  }
  return String(Number(value.toPrecision(digits))).replace('-', '−');
}

export function count(value) {
  return typeof value === 'number' ? value.toLocaleString('en') : kMissing;
}

export function vector(values, digits = 3) {
  return Array.isArray(values) ? values.map((value) => fixed(value, digits)).join(', ') : kMissing;
}

/// Microseconds in the unit that reads best.
export function time_span(microseconds) {
  if (typeof microseconds !== 'number') return { value: kMissing, unit: '' };
  if (microseconds < 1000) return { value: significant(microseconds, 3), unit: 'µs' };
  if (microseconds < 1e6) return { value: significant(microseconds / 1e3, 3), unit: 'ms' };
  return { value: significant(microseconds / 1e6, 3), unit: 's' };
}
