// A person's corrections of one photograph, as a value that never changes: what each image that was found became, which
// are left out, which were added, and the surface line. Coordinates: column and row from the top. Angles in degrees,
// counter-clockwise as seen. Pure.
//
// found:  {images: [...], surface_px} as the digitizer left them (GET .../corrections)
// edits:  {changed: {index: measured}, removed: [index], added: [{id, measured}], surface: null or {ends: [left, right], sd_px}}
// measured: {centre, diameter_px, equator_deg, no_equator, leg, and further keys of the file as they are there}

export const noEdits = Object.freeze({ changed: {}, removed: [], added: [], surface: null });

export const foundKey = (index) => `found-${index}`;
const addedKey = (id) => `added-${id}`;

/// {index} of an image that was found, {id} of one that was added.
function partsOf(key) {
  const [kind, number] = key.split("-");
  return kind === "found" ? { index: Number(number) } : { id: Number(number) };
}

export function isEmpty(edits) {
  return Object.keys(edits.changed).length === 0 && edits.removed.length === 0 && edits.added.length === 0 && !edits.surface;
}

/// What is measured by hand of it so far.
export function measuredOf(edits, key) {
  const { index, id } = partsOf(key);
  return (index === undefined ? edits.added.find((each) => each.id === id)?.measured : edits.changed[index]) ?? {};
}

export const isRemoved = (edits, key) => edits.removed.includes(partsOf(key).index);
export const isChanged = (edits, key) => partsOf(key).index in edits.changed;

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
