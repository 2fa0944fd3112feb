/// The multiples of `step` in [low, high].
export function multiples(low, high, step) {
  const result = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; ++i) result.push(Number((i * step).toPrecision(12)));
  return result;
}

/// Round numbers in [low, high], about `wanted` of them.
export function ticks(low, high, wanted) {
  return multiples(low, high, tick_step(high - low, wanted));
}

/// The least of 1, 2 or 5 times a power of ten that cuts `range` into at most `wanted` steps.
export function tick_step(range, wanted) {
  const raw = Math.max(range, 1e-9) / wanted;
  const power = 10 ** Math.floor(Math.log10(raw));
  return power * [1, 2, 5, 10].find((factor) => factor * power >= raw * (1 - 1e-9));
}

/// Decimals that tell neighbouring ticks apart.
export function tick_digits(step) {
  return Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
}
