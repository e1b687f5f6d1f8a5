// What a shot has to say on demand: all numbers, the uncertainty budget, the flash train, who digitized it.
import { ABSENT, rounded, significant, unitWords } from "../words/numbers.js";
import { dateAndTime } from "../words/times.js";
import { fill, h } from "./dom.js";
import { details, quiet } from "./notices.js";
import { table } from "./table.js";

/// kept: {open: Set of ids, budgetOf: name of a quantity}, what a person has chosen, from one shot to the next.
export function shotDetails(quantities, detail, kept) {
  const ontoggle = ({ target }) => (target.open ? kept.open.add(target.id) : kept.open.delete(target.id));
  const part = (id, title, content) =>
    content && details(title, content, { id, open: kept.open.has(id), ontoggle });
  return [
    part("all-numbers", "All numbers", detail.readout && allNumbers(quantities, detail)),
    part("budget", "Uncertainty budget", detail.budget && budgets(quantities, detail, kept)),
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

function budgets(quantities, { budget }, kept) {
  const known = quantities.filter((q) => budget[q.name]?.length);
  if (known.length === 0) return quiet("No number, no budget.");
  const place = h("div");
  const show = (name) => {
    const chosen = known.find((q) => q.name === name) ?? known[0];
    kept.budgetOf = chosen.name;
    fill(place, budgetTable(chosen, budget));
  };
  const select = h(
    "select",
    { onchange: () => show(select.value) },
    known.map((q) => h("option", { value: q.name }, q.label)),
  );
  show(kept.budgetOf);
  select.value = kept.budgetOf;
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
