// What a shot has to say on demand: all numbers, the uncertainty budget, the flash train, who digitized it.
import { ABSENT, dateAndTime, rounded, significant, unitWords, valueAndSd } from "../words/numbers.js";
import { condition, digitizationWords, meanCells } from "../words/shots.js";
import { choice, details, fill, h, quiet } from "./dom.js";
import { QUANTITY, table, UNIT } from "./table.js";

/// kept: {open: Set of ids, budgetOf: name of a quantity}, what a person has chosen, from one shot to the next.
export function shotDetails(quantities, detail, kept) {
  const part = (id, title, content) => content && keptDetails(kept, id, title, content);
  const { readout, budget, train, digitizations, record = readout?.record } = detail;
  return [
    detail.spin_axis &&
      h("img", { class: "spin-axis", src: detail.spin_axis, alt: detail.spatial_words.join(". ") }),
    part("all-numbers", "All numbers", readout && allNumbers(quantities, detail)),
    part("budget", "Uncertainty budget", budget && budgets(quantities, detail, kept)),
    part("train", "Flash train", train && trainTable(train)),
    part("digitizations", "Digitizations", digitizations?.length && digitizationList(digitizations)),
    part("record", "Record", hasEntries(record) && factsTable("Record of the session", record)),
  ].filter(Boolean);
}

/// Open as the last time.
export function keptDetails(kept, id, title, content) {
  const ontoggle = ({ target }) => (target.open ? kept.open.add(target.id) : kept.open.delete(target.id));
  return details(title, content, { id, open: kept.open.has(id), ontoggle });
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
        ...["sd", "sd_systematic", "expanded_uncertainty"].map((kind) => plusMinus(readout[kind]?.[q.name])),
      ],
    };
  });
  const columns = [QUANTITY, "value", UNIT, "total sd", "of noise", "of ball and air", "95 %"];
  return [
    table("All numbers of the shot with their uncertainties", columns, rows, { hideCaption: true }),
    Number.isFinite(readout.residual_ratio) &&
      quiet(`Residuals are ${significant(readout.residual_ratio, 3)} times the stated noise.`),
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
  show(kept.budgetOf);
  const options = known.map((q) => [q.name, q.label]);
  return [choice("Number", options, kept.budgetOf, show).element, place];
}

function budgetTable(quantity, budget) {
  const lines = budget[quantity.name];
  const or = (number, digits) => (number === null ? "" : significant(number, digits));
  const rows = lines.map((line) => ({
    head: line.source,
    cells: [
      line.type,
      line.input_sd === null ? "" : `${significant(line.input_sd, 3)} ${line.input_unit ?? ""}`.trim(),
      or(line.sensitivity, 3),
      significant(line.effect),
      `${significant(100 * line.share, 3)} %`,
      or(line.degrees_of_freedom, 3),
      line.shared ? "yes" : "no",
    ],
  }));
  const total = Math.sqrt(lines.reduce((sum, line) => sum + line.effect ** 2, 0));
  rows.push({ head: "total", class: "total", cells: ["", "", "", significant(total), "", "", ""] });
  const unit = unitWords(quantity.unit);
  const columns = [
    { title: "source", words: true },
    ...["type", "input's sd", "sensitivity"],
    { title: "effect", unit },
    ...["share", "freedom", "shared"],
  ];
  return table(`What the uncertainty of ${quantity.label} is made of`, columns, rows);
}

function digitizationList(all) {
  return h(
    "ol",
    { class: "plain-list" },
    all.map(({ utc, who, kind }) =>
      h("li", {}, [digitizationWords(kind), who, utc && `${dateAndTime(utc)} UTC`].filter(Boolean).join(", ")),
    ),
  );
}

export const trainTable = (train) => factsTable("Flash train", train);

/// Any object of plain values, nested ones with their names joined.
function factsTable(caption, object) {
  const rows = entries(object).map(([name, value]) => ({ head: name.replaceAll("_", " "), cells: [value] }));
  const columns = [
    { title: "what", hidden: true },
    { title: "value", hidden: true, words: true },
  ];
  return table(caption, columns, rows, { hideCaption: true });
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

export const hasNumbers = ({ values }) => Object.values(values ?? {}).some((n) => Number.isFinite(n?.value));

export function essentialsTable(quantities, shot, series) {
  const summary = series?.counted > 0 ? series : null;
  // The court pace is the ITF's for shots as it prescribes them only.
  const hasPace = shot.readout?.court_pace_conforming;
  const shown = quantities.filter((q) => q.essential || (q.name === "court_pace" && hasPace));
  const rows = shown.map((q) => {
    const { value, sd } = valueAndSd(shot.values?.[q.name]);
    const { mean, expanded } = meanCells(summary?.quantities?.[q.name]);
    const means = summary ? [mean, expanded && `± ${expanded}`] : [];
    return { head: q.label, cells: [value, sd && `± ${sd}`, unitWords(q.unit), ...means] };
  });
  const columns = [QUANTITY, "value", "± sd", UNIT, ...(summary ? ["series' mean", "± 95 %"] : [])];
  const which = [shot.name, condition(shot)].filter(Boolean).join(", ");
  const look = { hideCaption: true, className: "essentials" };
  return table(`Shot ${which}: value with its total standard uncertainty`, columns, rows, look);
}
