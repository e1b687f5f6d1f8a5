// A series' table: mean, what it is uncertain by and from what, the thesis's row beside it.
import { table } from "./table.js";
import { ABSENT, fixed, rounded, signed, unitWords } from "../words/numbers.js";
import { digitsOf, shotsWords } from "../words/series.js";

export function summaryTable(quantities, series) {
  const { summary } = series;
  const beside = series.thesis ?? null;
  const rows = quantities
    .filter((q) => summary.quantities?.[q.name]?.n > 0)
    .map((q) => summaryRow(q, summary.quantities[q.name], beside));
  const columns = [
    { title: "quantity", hidden: true },
    { title: "unit", hidden: true, words: true },
    { title: "mean" },
    { title: "± 95 %" },
    { title: "total sd" },
    { title: "scatter" },
    { title: "std error" },
    { title: "shared" },
    { title: "n" },
  ];
  if (beside) columns.push({ title: "thesis" }, { title: "± sd" }, { title: "off by, its sd" });
  return table(`${summary.series || "Series"}: ${shotsWords(summary)}`, columns, rows);
}

function summaryRow(q, s, beside) {
  const sd = digitsOf(s);
  const cell = (number) => (Number.isFinite(number) ? rounded(number, sd) : ABSENT);
  const cells = [
    unitWords(q.unit),
    cell(s.mean),
    cell(s.expanded_uncertainty),
    cell(s.total_sd),
    cell(s.scatter_sd),
    cell(s.standard_error),
    cell(s.shared_sd),
    String(s.n),
  ];
  return { head: q.label, cells: beside ? [...cells, ...thesisCells(beside[q.name], s.mean)] : cells };
}

function thesisCells(row, mean) {
  if (!row || !Number.isFinite(row.value)) return ["", "", ""];
  const off = Number.isFinite(mean) && row.sd > 0 ? signed((mean - row.value) / row.sd, 1) : "";
  return [fixed(row.value, 2), `± ${fixed(row.sd, 2)}`, off];
}

export function pointsTable(quantities, series) {
  const rows = series.points.map((point) => ({
    head: point.name,
    class: point.counted ? null : "rejected",
    cells: [
      ...quantities.map((q) => {
        const number = point.values?.[q.name];
        return number && Number.isFinite(number.value) ? rounded(number.value, number.sd) : ABSENT;
      }),
      point.counted ? "counted" : `rejected: ${point.rejected ?? "not counted"}`,
    ],
  }));
  const columns = [
    { title: "shot" },
    ...quantities.map((q) => ({ title: q.label, unit: unitWords(q.unit) })),
    { title: "counts", words: true },
  ];
  return table("All shots of the series", columns, rows, { hideCaption: true });
}
