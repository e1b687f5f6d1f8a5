// Corrections as the text that `strobe shot --edit` reads, and as the host tells them. Pure.

import { imageAt } from "../photograph/geometry.js";
import { noEdits } from "./state.js";

/// Names in the file of what `measured` calls otherwise: these are in px of the photograph.
const fileNames = { centre: "centre_image_px", diameter_px: "diameter_image_px", equator_deg: "equator_image_deg", top: "top_image_px" };
const order = ["centre", "centre_sd_px", "diameter_px", "diameter_sd_px", "equator_deg", "equator_sd_deg", "no_equator", "leg",
  "top", "contact_width_px", "time_s"];

function numberText(value) {
  const rounded = Number(value.toFixed(3));
  return Number.isInteger(rounded) ? rounded.toFixed(1) : String(rounded);
}

function valueText(name, value) {
  if (typeof value === "boolean") return String(value);
  if (typeof value === "string") return JSON.stringify(value);
  if (Array.isArray(value)) return `[${value.map((each) => valueText(name, each)).join(", ")}]`;
  return name === "time_s" ? String(value) : numberText(value);
}

function table(heading, entries) {
  return [heading, ...entries.map(([name, value]) => `${name} = ${valueText(name, value)}`), ""].join("\n");
}

/// A line turned all the way round is the same line; the file's range ends somewhere.
const told = (name, value) => (name === "equator_deg" && Math.abs(value) > 180 ? value - 180 * Math.round(value / 180) : value);

const measuredEntries = (measured) =>
  order.filter((name) => name in measured).map((name) => [fileNames[name] ?? name, told(name, measured[name])]);

function surfaceEntries({ ends: [left, right], sd_px: sd }) {
  return [["left_image_px", left], ["right_image_px", right], ...(sd > 0 ? [["sd_px", sd]] : [])];
}

/// "" where there is nothing to correct.
export function correctionsText(found, edits) {
  const at = (index) => ["at_image_px", found.images[index].centre_px];
  const tables = [
    ...edits.removed.map((index) => table("[[remove]]", [at(index)])),
    ...Object.keys(edits.changed).map(Number).sort((a, b) => a - b)
      .map((index) => table("[[move]]", [at(index), ...measuredEntries(edits.changed[index])])),
    ...edits.added.map(({ measured }) => table("[[add]]", measuredEntries(measured))),
  ];
  if (edits.surface) tables.push(table("[surface]", surfaceEntries(edits.surface)));
  return tables.join("\n");
}

/**
 * The host's list of the corrections that count ([{kind, at_px, centre_px, ...}], in px of the photograph) as edits.
 * Those that mean no image (`lost`) cannot be: there are none, unless the digitizer changed meanwhile.
 */
export function editsFromList(found, list) {
  const edits = { ...noEdits, changed: {}, removed: [], added: [] };
  const lost = [];
  for (const { kind, at_px: at, left_px: left, right_px: right, centre_px: centre, top_px: top, ...rest } of list) {
    const measured = { ...rest, ...(centre ? { centre } : {}), ...(top ? { top } : {}) };
    if (kind === "surface") {
      edits.surface = { ends: [left, right], ...(rest.sd_px > 0 ? { sd_px: rest.sd_px } : {}) };
      continue;
    }
    if (kind === "add") {
      edits.added.push({ id: edits.added.length + 1, measured });
      continue;
    }
    const index = imageAt(found.images, at, 0);
    if (index < 0) lost.push({ kind, at });
    else if (kind === "remove") edits.removed.push(index);
    else edits.changed[index] = measured;
  }
  edits.removed.sort((a, b) => a - b);
  return { edits, lost };
}
