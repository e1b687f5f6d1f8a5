// A series in words. Pure.
import { ABSENT, count, rounded, signed } from "./numbers.js";

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
