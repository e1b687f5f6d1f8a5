// The numbers of what is chosen, to be typed: the same that drags and keys change.

import { h } from "../parts/dom.js";
import { button } from "../photograph/controls.js";
import { nameOf } from "../photograph/words.js";

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
