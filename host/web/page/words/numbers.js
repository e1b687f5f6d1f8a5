// Numbers and times for a person: numbers with as many decimals as in the terminal, times always UTC, as in the files of a session.
// Pure.

const MINUS = "\u2212";
export const ABSENT = "–";

/// Decimals for so many digits of the standard uncertainty (two: GUM 7.2.6), at most 6; 3 where it is unknown.
export function decimalsFor(sd, digits = 2) {
  const known = Number.isFinite(sd) && sd > 0;
  const decimals = known ? digits - 1 - Math.floor(Math.log10(sd)) : 3;
  return Math.min(Math.max(decimals, 0), 6);
}

/// A rounded zero has no sign.
export function fixed(value, decimals) {
  if (!Number.isFinite(value)) return ABSENT;
  const text = Math.abs(value).toFixed(decimals);
  return value < 0 && Number(text) !== 0 ? MINUS + text : text;
}

export function rounded(value, sd, digits = 2) {
  return value === null || value === undefined ? ABSENT : fixed(value, decimalsFor(sd, digits));
}

/// With a sign, also of a positive number.
export function signed(value, decimals) {
  const text = fixed(value, decimals);
  return value > 0 && text !== ABSENT ? `+${text}` : text;
}

/// {value: "15.37", sd: "0.19"}; sd is "" where it is not known.
export function valueAndSd(number, digits = 2) {
  if (!number || number.value === null || number.value === undefined) return { value: ABSENT, sd: "" };
  const { value, sd } = number;
  return { value: rounded(value, sd, digits), sd: Number.isFinite(sd) ? rounded(sd, sd, digits) : "" };
}

/// "15.37 ± 0.19 m/s"
export function inWords(number, unit) {
  const { value, sd } = valueAndSd(number);
  return [value, sd && `± ${sd}`, value !== ABSENT && unitWords(unit)].filter(Boolean).join(" ");
}

export function unitWords(unit) {
  return { deg: "°", us: "µs" }[unit] ?? unit ?? "";
}

/// Like printf's %.ng, without exponents between 1e-5 and 1e6.
export function significant(value, digits = 2) {
  if (!Number.isFinite(value)) return ABSENT;
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size < 1e-5 || size >= 1e6)
    return value
      .toExponential(digits - 1)
      .replace("e+", "e")
      .replaceAll("-", MINUS);
  const decimals = Math.max(0, digits - 1 - Math.floor(Math.log10(size)));
  const text = fixed(value, decimals);
  return text.includes(".") ? text.replace(/\.?0+$/, "") : text;
}

/// A time of some microseconds: "0.02 µs", "12 µs", "1.4 ms".
export function microseconds(us) {
  if (!Number.isFinite(us)) return ABSENT;
  if (Math.abs(us) >= 1000) return `${significant(us / 1000, 3)} ms`;
  return `${fixed(us, Math.abs(us) >= 100 ? 0 : Math.abs(us) >= 10 ? 1 : 2)} µs`;
}

export function count(n, one, many = `${one}s`) {
  return `${n} ${n === 1 ? one : many}`;
}

/// "2026-11-23 14:02:11"
export function dateAndTime(utc) {
  return utc ? utc.slice(0, 19).replace("T", " ") : "";
}

/// "14:02:11"
export function timeOfDay(utc) {
  return utc ? utc.slice(11, 19) : "";
}

/// "8 s", "3 min", "5 h", "12 days"
export function duration(seconds) {
  if (!Number.isFinite(seconds)) return "an unknown time";
  if (seconds < 100) return `${Math.round(seconds)} s`;
  if (seconds < 100 * 60) return `${Math.round(seconds / 60)} min`;
  if (seconds < 48 * 3600) return `${Math.round(seconds / 3600)} h`;
  return `${Math.round(seconds / 86400)} days`;
}
