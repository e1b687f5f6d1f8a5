// What a run chart of one quantity shows: its points in the order fired, its lines, its range. Pure.

/// A thesis row that would squeeze the points to less than a quarter of the height is told in words instead.
const LARGEST_STRETCH = 4;

/// {points: [{index, name, utc, counted, rejected, value, sd}], mean, lower, upper, thesis: {value, sd, isShown}|null, range}
export function runChart(series, name) {
  const points = (series.points ?? []).map((point, index) => ({
    index,
    name: point.name,
    utc: point.utc,
    counted: Boolean(point.counted),
    rejected: point.rejected ?? null,
    value: point.values?.[name]?.value ?? null,
    sd: point.values?.[name]?.sd ?? null,
  }));
  const summary = series.summary?.quantities?.[name];
  const mean = summary?.n ? summary.mean : null;
  const { lower = null, upper = null } = series.limits?.[name] ?? {};
  const own = points
    .filter((p) => p.value !== null)
    .flatMap((p) => [p.value - (p.sd ?? 0), p.value + (p.sd ?? 0)]);
  const narrow = rangeOf([...own, mean, lower, upper].filter((v) => v !== null));
  const thesis = thesisRow(series.thesis?.[name], narrow);
  const range = thesis?.isShown
    ? rangeOf([...narrow, thesis.value - thesis.sd, thesis.value + thesis.sd], 0.02)
    : narrow;
  return { points, mean, lower, upper, thesis, range };
}

function thesisRow(row, [low, high]) {
  if (!row || !Number.isFinite(row.value)) return null;
  const sd = row.sd ?? 0;
  const stretched = Math.max(high, row.value + sd) - Math.min(low, row.value - sd);
  return {
    value: row.value,
    sd,
    isShown: stretched <= LARGEST_STRETCH * (high - low),
    isAbove: row.value > high,
  };
}

/// The point whose place is nearest to `index`, from 0; null without points.
export function nearestPoint(points, index) {
  if (points.length === 0) return null;
  return points[Math.min(points.length - 1, Math.max(0, Math.round(index)))];
}

/// At most about `most` points, those whose number is round, or where names are no numbers, whose place is.
export function labelled(points, most) {
  const every = Math.max(1, roundStep(0, Math.max(points.length, 2), Math.max(2, most)));
  const numbers = points.map((point) => Number(point.name));
  const areNumbers = numbers.every(
    (number, i) => Number.isInteger(number) && (i === 0 || number > numbers[i - 1]),
  );
  return points.filter((point, i) => (areNumbers ? numbers[i] : point.index + 1) % every === 0);
}

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
