// Axes: round numbers for ticks, and a value's place on a line of pixels. Pure.

/// The round step (1, 2 or 5 times a power of ten) that gives at most `most` intervals between low and high.
export function roundStep(low, high, most) {
  const rough = (high - low) / most;
  const power = 10 ** Math.floor(Math.log10(rough));
  return [1, 2, 5, 10].map((factor) => factor * power).find((step) => step >= rough * (1 - 1e-9));
}

/// {ticks: [numbers, ascending], decimals}; low < high.
export function roundTicks(low, high, most = 4) {
  const step = roundStep(low, high, most);
  const first = Math.ceil(low / step - 1e-9);
  const last = Math.floor(high / step + 1e-9);
  const ticks = [];
  for (let i = first; i <= last; ++i) ticks.push(i * step);
  return { ticks, decimals: Math.min(Math.max(0, -Math.floor(Math.log10(step) + 1e-9)), 9) };
}

/// [low, high] about all finite values, with a little room; some room about a single one; [0, 1] without any.
export function rangeOf(values, room = 0.06) {
  const finite = values.filter(Number.isFinite);
  if (finite.length === 0) return [0, 1];
  const low = Math.min(...finite),
    high = Math.max(...finite);
  const margin = high > low ? room * (high - low) : Math.abs(high) * 0.01 || 1;
  return [low - margin, high + margin];
}

export function linear([low, high], [from, to]) {
  return (value) => from + ((value - low) / (high - low)) * (to - from);
}
