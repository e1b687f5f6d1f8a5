// What a shot has to say on demand: all numbers, the uncertainty budget, the flash train, who digitized it.
import { ABSENT, rounded, significant, unitWords } from "../words/numbers.js";
import { dateAndTime } from "../words/times.js";
import { fill, h } from "./dom.js";
import { details, quiet } from "./notices.js";
import { table } from "./table.js";

export function shotDetails(quantities, detail, isOpen) {
  const part = (id, title, content) => content && details(title, content, { id, open: isOpen.has(id) });
  return [
    part("all-numbers", "All numbers", detail.readout && allNumbers(quantities, detail)),
    part("budget", "Uncertainty budget", detail.budget && budgets(quantities, detail)),
    part("train", "Flash train", detail.train && trainTable(detail.train)),
    part(
      "digitizations",
      "Digitizations",
      detail.digitizations?.length && digitizations(detail.digitizations),
    ),
    part(
      "record",
      "Record",
      hasEntries(detail.readout?.record) && factsTable("Record of the session", detail.readout.record),
    ),
  ].filter(Boolean);
}

function hasEntries(object) {
  return Boolean(object) && Object.values(object).some((value) => value !== "" && value !== null);
}

function allNumbers(quantities, { readout, values }) {
  const rows = quantities.map((q) => {
    const total = values?.[q.name]?.sd ?? null;
    const plusMinus = (number) => (Number.isFinite(number) ? `± ${rounded(number, total)}` : "");
    return {
      head: q.label,
      cells: [
        rounded(values?.[q.name]?.value, total),
        unitWords(q.unit),
        plusMinus(total),
        plusMinus(readout.sd?.[q.name]),
        plusMinus(readout.sd_systematic?.[q.name]),
        plusMinus(readout.expanded_uncertainty?.[q.name]),
      ],
    };
  });
  const columns = [
    { title: "quantity", hidden: true },
    { title: "value" },
    { title: "unit", hidden: true, words: true },
    { title: "total sd" },
    { title: "of noise" },
    { title: "of ball and air" },
    { title: "95 %" },
  ];
  const ratio = Number.isFinite(readout.residual_ratio)
    ? quiet(`Residuals are ${significant(readout.residual_ratio, 3)} times the stated noise.`)
    : null;
  return [
    table("All numbers of the shot with their uncertainties", columns, rows, { hideCaption: true }),
    ratio,
  ];
}

function budgets(quantities, { budget }) {
  const known = quantities.filter((q) => budget[q.name]?.length);
  if (known.length === 0) return quiet("No number, no budget.");
  const place = h("div");
  const select = h(
    "select",
    {
      onchange: () =>
        fill(
          place,
          budgetTable(
            known.find((q) => q.name === select.value),
            budget,
          ),
        ),
    },
    known.map((q) => h("option", { value: q.name }, q.label)),
  );
  fill(place, budgetTable(known[0], budget));
  return [h("label", { class: "choice" }, h("span", {}, "Number"), select), place];
}

export function budgetTable(quantity, budget) {
  const lines = budget[quantity.name];
  const rows = lines.map((line) => ({
    head: line.source,
    cells: [
      line.type,
      line.input_sd === null ? "" : `${significant(line.input_sd, 3)} ${line.input_unit ?? ""}`.trim(),
      line.sensitivity === null ? "" : significant(line.sensitivity, 3),
      significant(line.effect),
      `${significant(100 * line.share, 3)} %`,
      line.degrees_of_freedom === null ? "" : significant(line.degrees_of_freedom, 3),
      line.shared ? "yes" : "no",
    ],
  }));
  const total = Math.sqrt(lines.reduce((sum, line) => sum + line.effect ** 2, 0));
  rows.push({ head: "total", class: "total", cells: ["", "", "", significant(total), "", "", ""] });
  const unit = unitWords(quantity.unit);
  const columns = [
    { title: "source", words: true },
    { title: "type" },
    { title: "input's sd" },
    { title: "sensitivity" },
    { title: "effect", unit },
    { title: "share" },
    { title: "freedom" },
    { title: "shared" },
  ];
  return table(`What the uncertainty of ${quantity.label} is made of`, columns, rows);
}

function digitizations(list) {
  const kinds = { auto: "by the program", hand: "by hand", corrected: "corrected by hand" };
  return h(
    "ol",
    { class: "plain-list" },
    list.map(({ utc, who, kind }) =>
      h("li", {}, `${kinds[kind] ?? kind}${who ? `, ${who}` : ""}${utc ? `, ${dateAndTime(utc)} UTC` : ""}`),
    ),
  );
}

export function trainTable(train) {
  return factsTable("Flash train", train);
}

/// Any object of plain values, nested ones with their names joined.
function factsTable(caption, object) {
  const rows = entries(object).map(([name, value]) => ({ head: name.replaceAll("_", " "), cells: [value] }));
  return table(
    caption,
    [
      { title: "what", hidden: true },
      { title: "value", hidden: true, words: true },
    ],
    rows,
    { hideCaption: true },
  );
}

function entries(object, prefix = "") {
  return Object.entries(object).flatMap(([name, value]) => {
    if (value === "" || (Array.isArray(value) && value.length === 0)) return [];
    if (value && typeof value === "object" && !Array.isArray(value))
      return entries(value, `${prefix}${name} `);
    return [[prefix + name, textOf(value)]];
  });
}

function textOf(value) {
  if (value === null) return ABSENT;
  if (typeof value === "number") return Number.isInteger(value) ? String(value) : significant(value, 4);
  if (typeof value === "boolean") return value ? "yes" : "no";
  return Array.isArray(value) ? value.map(textOf).join(", ") : String(value);
}
