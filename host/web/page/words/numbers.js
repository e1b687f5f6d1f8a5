// Numbers as the terminal shows them (host/text/text.cpp). Pure.

const MINUS = "\u2212";
export const ABSENT = "–";

/// Decimals for two digits of the standard uncertainty (GUM 7.2.6), at least `least`, at most 6; 3 where it is unknown.
export function decimalsFor(sd, least = 0) {
  let decimals = 3;
  if (Number.isFinite(sd) && sd > 0) decimals = 1 - Math.floor(Math.log10(sd));
  return Math.min(Math.max(decimals, least), 6);
}

/// Like printf's %.nf: a tie goes to the even digit, where toFixed goes away from zero.
export function fixed(value, decimals) {
  if (!Number.isFinite(value)) return ABSENT;
  const magnitude = Math.abs(value);
  let text = magnitude.toFixed(decimals);
  if (magnitude < 1e15 && isTie(magnitude, decimals) && isOdd(text))
    text = (Number(text) - 10 ** -decimals).toFixed(decimals);
  return value < 0 && Number(text) !== 0 ? MINUS + text : text;
}

/// Every double has finitely many decimals, and toFixed computes them exactly.
function isTie(magnitude, decimals) {
  const beyond = magnitude.toFixed(100).split(".")[1].slice(decimals);
  return /^50*$/.test(beyond);
}

function isOdd(text) {
  return Number(text.at(-1)) % 2 === 1;
}

export function rounded(value, sd, least = 0) {
  return value === null || value === undefined ? ABSENT : fixed(value, decimalsFor(sd, least));
}

/// With a sign, also of a positive number.
export function signed(value, decimals) {
  const text = fixed(value, decimals);
  return value > 0 && text !== ABSENT ? `+${text}` : text;
}

/// {value: "15.37", sd: "0.19"}; sd is "" where it is not known.
export function valueAndSd(number) {
  if (!number || number.value === null || number.value === undefined) return { value: ABSENT, sd: "" };
  const known = Number.isFinite(number.sd);
  return { value: rounded(number.value, number.sd), sd: known ? rounded(number.sd, number.sd) : "" };
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
