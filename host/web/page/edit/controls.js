// What stands beside the photograph while it is corrected: buttons, the list of who measured it and when, the numbers of what is
// chosen, and the table of what the corrections change.
import { h } from "../parts/dom.js";
import { button } from "../photograph/beside.js";
import { nameOf } from "../photograph/words.js";
import { dateAndTime, inWords, signed, significant } from "../words/numbers.js";
import { digitizationWords } from "../words/shots.js";

function lineOf({ utc, who, kind }, counts) {
  const by = [digitizationWords(kind), who && `by ${who}`].filter(Boolean).join(" ");
  return `${utc ? `${dateAndTime(utc)} UTC` : "at a time not known"}: ${by}${counts ? ", counts" : ""}`;
}

/// What cannot be done just now is marked, not disabled: a button that is loses the focus, and with it the keys.
/// act: {undo, redo, add, surface, save, discard, undoNewest, close}.
export function createActions(act) {
  const able = (words, action, options) => button(words, ({ currentTarget }) => {
    if (currentTarget.getAttribute("aria-disabled") !== "true") action();
  }, options);
  const buttons = {
    undo: able("Undo step", act.undo, { key: "Control+Z" }),
    redo: able("Redo step", act.redo, { key: "Control+Y" }),
    add: able("Add image", act.add, { key: "a" }),
    surface: able("Surface line", act.surface, { name: "Surface line: move its ends" }),
    save: able("Save", act.save, { className: "edit-save", name: "Save these corrections" }),
    discard: able("Discard", act.discard, { name: "Discard what is not saved" }),
    undoNewest: able("Undo the newest correction", act.undoNewest),
    close: able("Close", act.close, { name: "Close the corrections" }),
  };
  for (const name of ["add", "surface"]) buttons[name].setAttribute("aria-pressed", "false");
  const told = h("p", { class: "edit-told", role: "status" });
  const failed = h("p", { class: "edit-problem", role: "alert" });
  const list = h("ol", { class: "edit-digitizations" });
  const head = h("div", { class: "edit-buttons", role: "toolbar", "aria-label": "Correct" },
    buttons.undo, buttons.redo, buttons.add, buttons.surface);
  const foot = h("div", { class: "edit-buttons" }, buttons.save, buttons.discard, buttons.close);
  const history = h("section", { class: "edit-history", "aria-label": "Who measured it" }, h("h3", {}, "Who measured it"),
    list, h("p", { class: "edit-note" }, "The newest counts; the first always stays."), buttons.undoNewest);
  const keys = h("details", { class: "edit-keys" }, h("summary", {}, "Keys"), h("ul", {},
    ...["Tab, Enter: choose an image", "arrows: move it by 0.1 px, with Shift by 1 px", "[ and ]: diameter by 0.1 px, { and } by 1 px",
      ", and . : turn the equator by 0.1°, < and > by 1°", "n: no equator is seen", "Delete: remove", "a: add an image",
      "Control+Z, Control+Y: a step back, forth", "Escape: choose nothing"].map((text) => h("li", {}, text))));

  return {
    head, foot, history, keys, told, failed,
    tell(words) {
      told.textContent = words;
      failed.textContent = "";
    },
    fail: (words) => { failed.textContent = words; },
    /// can: {undo, redo, save, discard, undoNewest}; pressed: {add, surface}.
    show(can, pressed, digitizations) {
      for (const [name, whether] of Object.entries(can)) buttons[name].setAttribute("aria-disabled", String(!whether));
      for (const [name, whether] of Object.entries(pressed)) buttons[name].setAttribute("aria-pressed", String(whether));
      list.replaceChildren(...digitizations.map((each) => h("li", {}, lineOf(each, each === digitizations.at(-1)))));
    },
  };
}

const degrees = 180 / Math.PI;
/// Standard deviations by hand, each of a number that was measured by hand.
const SDS = {
  centre_sd_px: { label: "Middle's sd, px", of: "centre" },
  diameter_sd_px: { label: "Diameter's sd, px", of: "diameter_px" },
  equator_sd_deg: { label: "Equator's sd, °", of: "equator_deg" },
};
const rounded = (value) => (Number.isFinite(value) ? String(Number(value.toFixed(3))) : "");

function numberField(label, step, set) {
  const input = h("input", { type: "number", step, inputmode: "decimal" });
  input.addEventListener("change", () => set(input.value === "" ? null : Number(input.value)));
  return {
    element: h("label", {}, h("span", {}, label), input),
    show(value) {
      const text = rounded(value);
      if (input.value !== text && Number(input.value || NaN) !== Number(text || NaN)) input.value = text;
    },
    enable: (whether) => { input.disabled = !whether; },
  };
}

function legField(set) {
  const select = h("select", {},
    h("option", { value: "" }, "found by the program"), h("option", { value: "incoming" }, "incoming"),
    h("option", { value: "contact" }, "touching the surface"), h("option", { value: "rebound" }, "rebound"));
  select.addEventListener("change", () => set(select.value || null));
  return { element: h("label", {}, h("span", {}, "Leg"), select), show: (leg) => { select.value = leg ?? ""; } };
}

function checkField(label, toggle) {
  const input = h("input", { type: "checkbox" });
  input.addEventListener("change", toggle);
  return { element: h("label", { class: "edit-check" }, input, h("span", {}, label)), show: (on) => { input.checked = Boolean(on); } };
}

function imageFields(model) {
  const centreOf = () => model.selectedItem().image.centre_px;
  const change = (words, values) => model.change(values, words);
  const column = numberField("Column, px", 0.1, (v) => v !== null && change("move", { centre: [v, centreOf()[1]] }));
  const row = numberField("Row, px", 0.1, (v) => v !== null && change("move", { centre: [centreOf()[0], v] }));
  const diameter = numberField("Diameter, px", 0.1, (v) => change("set the diameter of", { diameter_px: v > 0 ? v : null }));
  const equator = numberField("Equator, °", 0.1, (v) => change("turn the equator of", { equator_deg: v }));
  const none = checkField("No equator is seen", () => model.toggleEquator());
  const leg = legField((v) => change("set the leg of", { leg: v }));
  const sds = Object.entries(SDS).map(([name, { label, of }]) => ({ name, of,
    field: numberField(label, 0.1, (v) => change("say how well was measured", { [name]: v > 0 ? v : null })) }));
  const well = h("details", {}, h("summary", {}, "How well by hand"),
    h("p", {}, "Left empty: 0.5 mm, and 1° for the equator, as by hand on a tablet."), ...sds.map(({ field }) => field.element));
  const element = h("div", { class: "edit-fields" }, column.element, row.element, diameter.element, equator.element, none.element, leg.element, well);
  return {
    element,
    show({ key, image }) {
      const measured = model.measured(key);
      column.show(image.centre_px[0]);
      row.show(image.centre_px[1]);
      diameter.show(image.diameter_px);
      equator.show(image.equator_rad === null || image.equator_rad === undefined ? NaN : image.equator_rad * degrees);
      equator.enable(!measured.no_equator);
      none.show(measured.no_equator);
      leg.show(measured.leg);
      for (const { name, of, field } of sds) {
        field.show(measured[name]);
        field.enable(of in measured);
      }
    },
  };
}

function surfaceFields(model) {
  const set = (end, axis) => (v) => {
    if (v === null) return;
    const ends = model.surfaceEnds().map((p) => [...p]);
    ends[end][axis] = v;
    model.setSurface(ends);
  };
  const fields = [["Left end, column", 0, 0], ["Left end, row", 0, 1], ["Right end, column", 1, 0], ["Right end, row", 1, 1]]
    .map(([label, end, axis]) => ({ end, axis, field: numberField(label, 0.1, set(end, axis)) }));
  return {
    element: h("div", { class: "edit-fields" }, ...fields.map(({ field }) => field.element)),
    show(ends) {
      for (const { end, axis, field } of fields) field.show(ends?.[end][axis]);
    },
  };
}

const hints = {
  none: "Choose an image to correct it: click it, or Tab and Enter.",
  adding: "Click where the missing image is; or press Enter to put it in the middle of the view, then move it with the arrow keys.",
  surface: "Drag one of the line's two ends, or type where they are.",
  image: "Drag its middle, its rim or the end of its equator, use the keys, or type.",
  removed: "It is left out.",
};

export function createFields(model) {
  const heading = h("h3", {});
  const hint = h("p", { class: "edit-hint" });
  const image = imageFields(model);
  const surface = surfaceFields(model);
  const removing = button("Remove", () => model.remove(), { key: "Delete", name: "Remove this image" });
  const restoring = button("As it was found", () => (model.surfaceChosen() ? model.setSurface(null) : model.restore()));
  const element = h("section", { class: "edit-chosen", "aria-label": "What is chosen" }, heading, hint, image.element, surface.element,
    h("div", { class: "edit-buttons" }, removing, restoring));

  return {
    element,
    /// item: the chosen image with what the host made of it.
    show(item) {
      const kind = model.adding() ? "adding" : model.surfaceChosen() ? "surface" : !item ? "none" : item.status === "removed" ? "removed" : "image";
      heading.textContent = { none: "Nothing chosen", adding: "Add an image", surface: "Surface line" }[kind] ?? nameOf(item.image);
      hint.textContent = kind === "surface" && !model.surfaceEnds() ? "No surface line was found." : hints[kind];
      image.element.hidden = kind !== "image";
      surface.element.hidden = kind !== "surface";
      removing.hidden = kind !== "image";
      restoring.hidden = !(kind === "removed" || (kind === "image" && item.status === "changed") || (kind === "surface" && model.edits().surface));
      if (kind === "image") image.show(item);
      if (kind === "surface") surface.show(model.surfaceEnds());
    },
  };
}

function bodyOf(rows) {
  return rows.map(({ label, before, after, change }) => h("tr", { class: change.endsWith("large") ? "is-large" : null },
    h("th", { scope: "row" }, label), h("td", {}, before), h("td", {}, after), h("td", {}, change)));
}

function emptyTable(caption) {
  const body = h("tbody");
  const heads = ["", "before", "after", "change"].map((text) => (text ? h("th", { scope: "col" }, text) : h("td")));
  return { body, element: h("table", { class: "edit-table" }, h("caption", {}, caption), h("thead", {}, h("tr", {}, ...heads)), body) };
}

export function createTable() {
  const essentials = emptyTable("The readout, before and after");
  const others = emptyTable("Its other numbers");
  const rest = h("details", {}, h("summary", {}, "All numbers"), h("div", { class: "edit-wide", tabindex: "0", role: "group", "aria-label": "All numbers, before and after" }, others.element));
  const note = h("p", { class: "edit-note" }, "A change of one sd is as large as the value before was uncertain.");
  const state = h("p", { class: "edit-state" });
  const verdict = h("p", { class: "edit-verdict" });
  const problem = h("p", { class: "edit-problem", role: "alert" });
  const wide = h("div", { class: "edit-wide", tabindex: "0", role: "group", "aria-label": "The readout, before and after" }, essentials.element);
  const element = h("section", { class: "edit-comparison", "aria-label": "What the corrections change" }, state, problem, verdict, wide, rest, note);

  function showTables(whether) {
    for (const part of [wide, rest, note]) part.hidden = !whether;
  }
  showTables(false);
  return {
    element,
    /// answer: of a preview. Without numbers after the corrections those of the last ones stay, with what is wrong.
    show({ before, after, rejected, problem: words }, quantities) {
      problem.textContent = words ?? "";
      verdict.textContent = after ? verdictWords(rejected) : "";
      if (!after) return;
      const rows = comparisonRows(quantities, before, after);
      essentials.body.replaceChildren(...bodyOf(rows.filter((row) => row.essential)));
      others.body.replaceChildren(...bodyOf(rows.filter((row) => !row.essential)));
      showTables(rows.length > 0);
    },
    tell: (words) => { state.textContent = words; },
    fail: (words) => { problem.textContent = words; },
    clear() {
      problem.textContent = verdict.textContent = "";
      showTables(false);
    },
  };
}

const LARGE_SD = 1;

/// "+0.30 sd", of the value before; words where one of the two is not there.
export function changeWords(before, after) {
  const had = Number.isFinite(before?.value);
  const has = Number.isFinite(after?.value);
  if (!had || !has) return had ? "lost" : has ? "new" : "";
  const difference = after.value - before.value;
  if (difference === 0) return "none";
  const sd = before.sd > 0 ? before.sd : after.sd;
  if (!(sd > 0)) return significant(difference);
  const sds = difference / sd;
  const words = `${signed(sds, Math.abs(sds) < 9.95 ? 2 : 0)} sd`;
  return Math.abs(sds) > LARGE_SD ? `${words}, large` : words;
}

/// [{label, essential, before, after, change}] of the quantities that either has.
export function comparisonRows(quantities, before, after) {
  return quantities
    .filter(({ name }) => Number.isFinite(before?.[name]?.value) || Number.isFinite(after?.[name]?.value))
    .map(({ name, label, unit, essential }) => ({ label, essential, before: inWords(before?.[name], unit), after: inWords(after?.[name], unit),
      change: changeWords(before?.[name], after?.[name]) }));
}

/// Whether the shot counts, where corrections change that or it does not. rejected: {before, after}, words or null.
export function verdictWords(rejected) {
  const { before = null, after = null } = rejected ?? {};
  if (after) return before ? `The shot is still rejected: ${after}.` : `With these corrections the shot is rejected: ${after}.`;
  return before ? `With these corrections the shot counts; before it was rejected: ${before}.` : "";
}
