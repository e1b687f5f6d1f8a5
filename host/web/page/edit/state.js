// A person's corrections of one photograph, as a value that never changes: what each image that was found became, which
// are left out, which were added, and the surface line. Coordinates: column and row from the top. Angles in degrees,
// counter-clockwise as seen. Also as the text that `strobe shot --edit` reads, and as the host tells it. Pure.
//
// found:  {images: [...], surface_px} as the digitizer left them (GET .../corrections)
// edits:  {changed: {index: measured}, removed: [index], added: [{id, measured}], surface: null or {ends: [left, right], sd_px}}
// measured: {centre, diameter_px, equator_deg, no_equator, leg, and further keys of the file as they are there}
import { imageAt } from "../photograph/geometry.js";

export const noEdits = Object.freeze({ changed: {}, removed: [], added: [], surface: null });

export const foundKey = (index) => `found-${index}`;
const addedKey = (id) => `added-${id}`;

/// {index} of an image that was found, {id} of one that was added.
function partsOf(key) {
  const [kind, number] = key.split("-");
  return kind === "found" ? { index: Number(number) } : { id: Number(number) };
}

/// What is measured by hand of it so far.
export function measuredOf(edits, key) {
  const { index, id } = partsOf(key);
  return (index === undefined ? edits.added.find((each) => each.id === id)?.measured : edits.changed[index]) ?? {};
}

export const isRemoved = (edits, key) => edits.removed.includes(partsOf(key).index);

function withMeasured(edits, key, measured) {
  const { index, id } = partsOf(key);
  if (index === undefined)
    return { ...edits, added: edits.added.map((each) => (each.id === id ? { ...each, measured } : each)) };
  const changed = { ...edits.changed, [index]: measured };
  if (Object.keys(measured).length === 0) delete changed[index];
  return { ...edits, changed };
}

/// values: keys of `measured` to set; undefined or null takes one back.
export function measure(edits, key, values) {
  const measured = { ...measuredOf(edits, key), ...values };
  if (values.equator_deg !== undefined && values.equator_deg !== null) delete measured.no_equator;
  if (values.no_equator) for (const name of ["equator_deg", "equator_sd_deg"]) delete measured[name];
  for (const name of Object.keys(measured))
    if (measured[name] === undefined || measured[name] === null || measured[name] === false) delete measured[name];
  for (const [sd, value] of [["centre_sd_px", "centre"], ["diameter_sd_px", "diameter_px"], ["equator_sd_deg", "equator_deg"]])
    if (!(value in measured)) delete measured[sd];
  return withMeasured(edits, key, measured);
}

export function add(edits, centre, diameter_px) {
  const id = 1 + Math.max(0, ...edits.added.map((each) => each.id));
  const measured = { centre, ...(diameter_px > 0 ? { diameter_px } : {}) };
  return { edits: { ...edits, added: [...edits.added, { id, measured }] }, key: addedKey(id) };
}

export function remove(edits, key) {
  const { index, id } = partsOf(key);
  if (index === undefined) return { ...edits, added: edits.added.filter((each) => each.id !== id) };
  const { [index]: dropped, ...changed } = edits.changed;
  return { ...edits, changed, removed: [...new Set([...edits.removed, index])].sort((a, b) => a - b) };
}

/// As the digitizer found it.
export function restore(edits, key) {
  const { index } = partsOf(key);
  const { [index]: dropped, ...changed } = edits.changed;
  return { ...edits, changed, removed: edits.removed.filter((each) => each !== index) };
}

/// ends: null: as it was found.
export const setSurface = (edits, ends) => ({ ...edits, surface: ends && { ...edits.surface, ends } });

function merged(image, measured) {
  const next = { ...image, source: "hand" };
  if (measured.centre) Object.assign(next, { centre_px: measured.centre, centre_cov_px2: null, centre_sd_px: measured.centre_sd_px ?? null });
  if (measured.diameter_px) Object.assign(next, { diameter_px: measured.diameter_px, diameter_sd_px: measured.diameter_sd_px ?? null });
  if (measured.equator_deg !== undefined)
    Object.assign(next, { equator_rad: measured.equator_deg * Math.PI / 180, equator_sd_rad: (measured.equator_sd_deg ?? 1) * Math.PI / 180 });
  if (measured.no_equator) Object.assign(next, { equator_rad: null, equator_sd_rad: null });
  if (measured.leg) next.leg = measured.leg;
  return next;
}

/// [{key, image, status}], status "found", "changed", "removed" or "added".
export function itemsOf(found, edits) {
  const items = found.images.map((image, index) => {
    const key = foundKey(index);
    if (edits.removed.includes(index)) return { key, image, status: "removed" };
    const measured = edits.changed[index];
    return measured ? { key, image: merged(image, measured), status: "changed" } : { key, image, status: "found" };
  });
  const blank = { flash_index: null, leg: null, diameter_px: 0, equator_rad: null };
  for (const { id, measured } of edits.added)
    items.push({ key: addedKey(id), image: merged(blank, measured), status: "added" });
  return items;
}

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
