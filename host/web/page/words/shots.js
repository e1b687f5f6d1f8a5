// Shots, series and flags in words. Pure.
import { ABSENT, count, inWords, rounded, signed } from "./numbers.js";

/// "zero 23°, acrylic, ITF type 2" of a shot, or of a session, which may have several surfaces and balls; "" where nothing is
/// known.
export function condition(row) {
  const angle = Number.isFinite(row?.angle_deg) ? `${row.angle_deg}°` : "";
  const flight = [row?.spin, angle].filter(Boolean).join(" ");
  const names = ({ surface, ball, surfaces = [surface], balls = [ball] }) => [surfaces, balls];
  return [[flight], ...names(row ?? {})]
    .map((each) => each.filter(Boolean).join(" / "))
    .filter(Boolean)
    .join(", ");
}

/// "surface, operator and temperature" of the record's keys.
export function keyWords(keys) {
  const words = keys.map((key) => key.replace(/_(name|deg|c)$/, "").replaceAll("_", " "));
  return [words.slice(0, -1).join(", "), words.at(-1)].filter(Boolean).join(" and ");
}

/// {text, level, reason}: whether the shot counts.
export function verdict(shot) {
  if (shot.dry) return { text: "dry", level: "plain", reason: "lamps and shutter only, nothing was thrown" };
  if (shot.rejected) return { text: "rejected", level: "caution", reason: shot.rejected };
  if (shot.counted === false) return { text: "not counted", level: "plain", reason: "" };
  return { text: "counted", level: "plain", reason: "" };
}

export function flagWords(name) {
  return name.replaceAll("_", " ");
}

/// Why it does not count and its flags, but for those that the reason names already.
export function remarks(shot) {
  const { reason } = verdict(shot);
  const flags = (shot.flags ?? []).map(flagWords).filter((words) => !reason.includes(words));
  return [reason, flags.join(", ")].filter(Boolean).join("; ");
}

const DIGITIZATIONS = {
  auto: "measured by the program",
  hand: "measured by hand",
  corrected: "corrected by hand",
};

export function digitizationWords(kind) {
  return kind ? (DIGITIZATIONS[kind] ?? kind) : "";
}

/// One sentence for a listener: "Shot 7 counted: restitution e 0.8760 ± 0.0026."
export function announcement(shot, quantities) {
  const { text, reason } = verdict(shot);
  const told = ["e", "omega_lo_radps"]
    .map((name) => quantities.find((q) => q.name === name))
    .filter(Boolean)
    .filter((q) => Number.isFinite(shot.values?.[q.name]?.value))
    .map((q) => `${q.label} ${inWords(shot.values[q.name], q.unit)}`);
  const because = reason ? `: ${reason}` : "";
  return `Shot ${shot.name} ${text}${because}${told.length ? `. ${told.join(", ")}` : ""}.`;
}

/// What a series' row is rounded by, as in the terminal.
export function digitsOf(summary) {
  return summary?.total_sd ?? (summary?.shared_sd || null) ?? summary?.standard_error ?? 0;
}

/// {mean, expanded, n} of one quantity of a series, as text.
export function meanCells(summary) {
  if (!summary || !summary.n) return { mean: ABSENT, expanded: "", n: "" };
  const sd = digitsOf(summary);
  return {
    mean: rounded(summary.mean, sd),
    n: String(summary.n),
    expanded: summary.expanded_uncertainty === null ? "" : rounded(summary.expanded_uncertainty, sd),
  };
}

export function shotsWords(summary) {
  const rejected = summary.rejected > 0 ? `, ${summary.rejected} rejected` : "";
  return `${count(summary.counted ?? 0, "shot")} counted${rejected}`;
}

/// ["shot 4 stands apart in vx touchdown: +3.1 sd of the others; it counts"]
export function outlierWords(quantities, summary) {
  return (summary.outliers ?? []).map(({ shot, quantity, sds }) => {
    const label = quantities.find((q) => q.name === quantity)?.label ?? quantity;
    return `shot ${shot} stands apart in ${label}: ${signed(sds, 1)} sd of the others; it counts (Grubbs's test)`;
  });
}
