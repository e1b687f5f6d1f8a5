// A shot's photograph with what was measured on it; by hand, if the host allows it, corrected.
//
//   const shown = mountPhotograph(element, { session, shot, detail, canEdit, onEdited });
//   shown.update(detail)   the shot's detail again, after it changed
//   shown.editing          whether it is being corrected
//   shown.unsaved()        whether leaving would lose sight of corrections (they are kept in this tab)
//   shown.destroy()
import { hasDraft } from "./edit/host.js";
import { mountEditor } from "./edit/editor.js";
import { getJson, path } from "./live/api.js";
import { fill, h } from "./parts/dom.js";
import { button, createLegend, createPanel, createTools } from "./photograph/beside.js";
import {
  enlargement, firstTime, hatchedPlaces, imageAt, inTime, millimetresPerPx,
} from "./photograph/geometry.js";
import { createMarks } from "./photograph/marks.js";
import { createStage } from "./photograph/stage.js";

export function mountPhotograph(element, options) {
  if (options.detail.photograph) return new PhotographView(element, options);
  fill(element, h("p", { class: "photograph-missing" }, "This shot has no photograph."));
  let inner = null;
  return {
    update(detail) {
      if (inner) inner.update(detail);
      else if (detail.photograph) inner = new PhotographView(element, { ...options, detail });
    },
    get editing() { return inner?.editing ?? false; },
    unsaved: () => inner?.unsaved() ?? false,
    destroy: () => (inner ? inner.destroy() : fill(element)),
  };
}

class PhotographView {
  constructor(element, { session, shot, detail, canEdit, onEdited }) {
    Object.assign(this, { element, session, shot, detail, onEdited, chosen: null, editor: null });
    const { url, width_px: width, height_px: height } = detail.photograph;
    this.photo = { url, width, height };
    this.stage = createStage(this.photo, `Photograph of shot ${shot}`);
    this.marks = createMarks(this.stage.marks, this.photo);
    this.panel = createPanel();
    this.legend = createLegend();
    this.problem = h("p", { class: "photograph-problem", role: "status" });
    this.correct = button("Correct", () => this.edit(), { name: "Correct what was measured, by hand", className: "photograph-correct" });
    this.under = h("div", { class: "photograph-under" });
    this.unmeasured = createUnmeasured({ session, shot, changed: (light) => this.show(light) });
    this.side = h("div", { class: "photograph-side" }, this.panel.element);
    const tools = createTools(this.stage, this.unmeasured.button, canEdit && this.correct);
    this.frame = h("div", { class: "photograph" }, h("div", { class: "photograph-main" },
      tools, this.stage.element, this.problem, this.under, this.legend.element), this.side);
    fill(element, h("div", { class: "photograph-room" }, this.frame));
    this.chooser = createChooser({ stage: this.stage, marks: this.marks, items: () => this.items(), places: () => this.places(),
      chosen: () => this.chosen, choose: (key) => this.choose(key) });
    this.stage.element.addEventListener("photographfailed", () => {
      this.problem.textContent = "The photograph could not be loaded; what was measured on it is still shown.";
    });
    this.stage.watch((view) => this.marks.rescale(view.scale));
    this.stage.setTool(this.chooser);
    if (canEdit && hasDraft(session, shot)) this.problem.textContent = "Corrections of this shot are not saved yet: they are there under Correct.";
    this.show();
  }

  get editing() { return this.editor !== null; }

  items() {
    return inTime(this.detail.images).map((position) => ({ key: `image-${position}`, image: this.detail.images[position], status: "found" }));
  }

  /// As the shot's detail tells, or as they were asked for.
  unmeasuredPlaces() {
    return this.detail.unmeasured ?? this.unmeasured.places();
  }

  places() {
    return hatchedPlaces({ images: this.detail.images, unmeasured: this.unmeasuredPlaces() });
  }

  choose(key) {
    this.chosen = key;
    this.show();
  }

  show(light) {
    if (this.editor) return;
    if (light) this.problem.textContent = `Light: ${light}`;
    const items = this.items();
    const places = this.places();
    this.unmeasured.offer(!this.detail.unmeasured);
    const image = items.find((item) => item.key === this.chosen)?.image ?? null;
    const place = image ? null : places.find((_, position) => `place-${position}` === this.chosen) ?? null;
    if (!image && !place) this.chosen = null;
    const enlarged = enlargement(this.detail.images);
    this.stage.setFocus(image?.centre_px ?? place?.centre_px ?? null);
    this.marks.show({ items, places, surface_px: this.detail.surface_px, selected: this.chosen, enlarged, editing: false }, this.stage.view().scale);
    this.legend.show(enlarged);
    this.panel.show({ image, place, mmPerPx: millimetresPerPx(this.detail), first_s: firstTime(this.detail.images),
      unmeasured: this.unmeasuredPlaces() });
  }

  edit() {
    this.chosen = null;
    this.problem.textContent = "";
    this.frame.classList.add("is-editing");
    this.correct.hidden = this.panel.element.hidden = true;
    this.unmeasured.offer(false);
    this.editor = mountEditor({ session: this.session, shot: this.shot, detail: this.detail, photo: this.photo, stage: this.stage,
      marks: this.marks, legend: this.legend, side: this.side, under: this.under, ended: () => this.endEditing(), edited: this.onEdited });
  }

  endEditing() {
    this.editor.destroy();
    this.editor = null;
    this.frame.classList.remove("is-editing");
    this.correct.hidden = this.panel.element.hidden = false;
    this.stage.setTool(this.chooser);
    this.show();
    this.correct.focus();
  }

  update(detail) {
    this.detail = detail;
    this.editor?.update(detail);
    this.show();
  }

  unsaved() { return this.editor?.unsaved() ?? false; }

  destroy() {
    this.editor?.destroy();
    this.stage.destroy();
    fill(this.element);
  }
}

const REACH_PX = 22;

export function createChooser({ stage, marks, items, places, chosen, choose }) {
  /// Images first: places lie behind them.
  function keyAt(at) {
    const p = stage.photoPoint(at);
    const reach = REACH_PX / stage.view().scale;
    const list = items();
    const image = imageAt(list.map((item) => item.image), p, reach);
    if (image >= 0) return list[image].key;
    const place = imageAt(places(), p, reach);
    return place < 0 ? null : `place-${place}`;
  }

  stage.element.addEventListener("focusin", (event) => {
    const key = marks.keyOf(event.target);
    const image = items().find((item) => item.key === key)?.image;
    if (image && event.target.matches(":focus-visible")) stage.reveal(image.centre_px);
  });

  return {
    begin: () => null,
    click(at) {
      const key = keyAt(at);
      choose(key);
      if (key) marks.focus(key);
      return true;
    },
    key(event) {
      const key = marks.keyOf(event.target);
      if (event.key === "Escape" && chosen()) choose(null);
      else if (key && (event.key === "Enter" || event.key === " ")) choose(key === chosen() ? null : key);
      else return false;
      return true;
    },
  };
}

export function createUnmeasured({ session, shot, changed }) {
  let places = [], light;
  const asking = button("What was not measured", ask);

  async function ask() {
    asking.disabled = true;
    asking.textContent = "Asking …";
    try {
      ({ unmeasured: places, light } = await getJson(path("sessions", session, "shots", shot, "unmeasured")));
      asking.textContent = places.length > 0 ? "What was not measured" : "Nothing was left out";
    } catch (error) {
      asking.textContent = `Not told: ${error.message}. Ask again`;
      asking.disabled = false;
    }
    changed(light);
  }

  return {
    button: asking,
    places: () => places,
    /// Whether it is of use: not once it is known.
    offer(whether) {
      asking.hidden = !whether || places.length > 0;
    },
  };
}
