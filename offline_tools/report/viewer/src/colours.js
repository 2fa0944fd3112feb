// The speed scale: dark blue-violet over magenta to yellow, rising in lightness, readable on light and dark ground.

const kStops = ['#5145e5', '#8a3ddb', '#c1379f', '#e8586a', '#f98a3c', '#fcc52c'];
const kRgb = kStops.map((stop) => [1, 3, 5].map((i) => parseInt(stop.slice(i, i + 2), 16) / 255));

/// Colour [r, g, b] in 0 to 1 of a fraction in 0 to 1.
export function speed_colour(fraction) {
  const place = Math.min(Math.max(fraction, 0), 1) * (kRgb.length - 1);
  const low = Math.min(Math.floor(place), kRgb.length - 2);
  return kRgb[low].map((channel, i) => channel + (kRgb[low + 1][i] - channel) * (place - low));
}

export const kSpeedGradient = `linear-gradient(to right, ${kStops.join(', ')})`;

/// The same scale as stops of an SVG gradient.
export function speed_stops() {
  return kStops.map((stop, i) => `<stop offset="${i / (kStops.length - 1)}" stop-color="${stop}"/>`).join('');
}

/// A colour variable of the page's style, as the browser resolves it for the present theme.
export function style_colour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

/// Colours that tell components apart, the largest first; every other component is grey.
export const kComponentColours = ['#3b82d6', '#e8893c', '#3aa66b', '#c2508e', '#8a63d2', '#c9a227', '#37a3b5', '#d0524a'];
export const kOtherComponents = '#8b94a3';
