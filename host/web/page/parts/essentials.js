// The essential numbers of a shot, large, with the series' means beside them.
import { condition } from "../words/shots.js";
import { unitWords, valueAndSd } from "../words/numbers.js";
import { meanCells } from "../words/series.js";
import { table } from "./table.js";

/// Quantities of a person's first reading; the court pace is the ITF's for shots as it prescribes them only.
export function essentialRows(quantities, shot) {
  return quantities.filter(
    (q) => q.essential || (q.name === "court_pace" && shot.readout?.court_pace_conforming),
  );
}

export function hasNumbers(shot) {
  return Object.values(shot.values ?? {}).some((number) => Number.isFinite(number?.value));
}

export function essentialsTable(quantities, shot, series) {
  const summary = series?.counted > 0 ? series : null;
  const rows = essentialRows(quantities, shot).map((q) => {
    const { value, sd } = valueAndSd(shot.values?.[q.name]);
    const { mean, expanded } = meanCells(summary?.quantities?.[q.name]);
    return {
      head: q.label,
      cells: [
        value,
        sd && `± ${sd}`,
        unitWords(q.unit),
        ...(summary ? [mean, expanded && `± ${expanded}`] : []),
      ],
    };
  });
  const columns = [
    { title: "quantity", hidden: true },
    { title: "value" },
    { title: "± sd" },
    { title: "unit", hidden: true, words: true },
  ];
  if (summary) columns.push({ title: "series' mean" }, { title: "± 95 %" });
  return table(
    `Shot ${shot.name}${condition(shot) ? `, ${condition(shot)}` : ""}: value with its total standard uncertainty`,
    columns,
    rows,
    { hideCaption: true, className: "essentials" },
  );
}
