// The readout before and after corrections, and by how many standard deviations it changes. Pure.
import { inWords, signed, significant } from "../words/numbers.js";

const LARGE_SD = 1;

/// "+0.30 sd", of the value before; words where one of the two is not there.
export function changeWords(before, after) {
  const had = Number.isFinite(before?.value);
  const has = Number.isFinite(after?.value);
  if (!had || !has) return had ? "lost" : has ? "new" : "";
  const difference = after.value - before.value;
  if (difference === 0) return "none";
  const sd = before.sd > 0 ? before.sd : after.sd;
  if (!(sd > 0)) return significant(difference);
  const sds = difference / sd;
  const words = `${signed(sds, Math.abs(sds) < 9.95 ? 2 : 0)} sd`;
  return Math.abs(sds) > LARGE_SD ? `${words}, large` : words;
}

/// [{label, essential, before, after, change}] of the quantities that either has.
export function comparisonRows(quantities, before, after) {
  return quantities
    .filter(({ name }) => Number.isFinite(before?.[name]?.value) || Number.isFinite(after?.[name]?.value))
    .map(({ name, label, unit, essential }) => ({ label, essential, before: inWords(before?.[name], unit), after: inWords(after?.[name], unit),
      change: changeWords(before?.[name], after?.[name]) }));
}

/// Whether the shot counts, where corrections change that or it does not. rejected: {before, after}, words or null.
export function verdictWords(rejected) {
  const { before = null, after = null } = rejected ?? {};
  if (after) return before ? `The shot is still rejected: ${after}.` : `With these corrections the shot is rejected: ${after}.`;
  return before ? `With these corrections the shot counts; before it was rejected: ${before}.` : "";
}
