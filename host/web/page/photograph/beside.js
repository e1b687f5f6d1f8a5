// Beside the photograph: what was measured of the image that is chosen, in words, or why a place was not.
import { fill, h, svg } from "../parts/dom.js";
import { isAt } from "./geometry.js";
import { placeName } from "./marks.js";
import { measuredRows, nameOf } from "./words.js";

const HINT = "Choose an image on the photograph (click it, or Tab and Enter) to see what was measured of it, how well, or why not.";

/// Where an equator, a top … of this image was not measured: why.
function reasonsNear(image, unmeasured) {
  return unmeasured.filter((place) => place.what && place.what !== "image" && isAt(place, image));
}

export function createPanel() {
  const heading = h("h3", {}, "No image chosen");
  const list = h("dl", { class: "photograph-measured" });
  const remark = h("p", {}, HINT);
  const element = h("section", { class: "photograph-panel", "aria-live": "polite", "aria-label": "The chosen image" }, heading, remark, list);
  return {
    element,
    show({ image, place, mmPerPx, first_s, unmeasured }) {
      heading.textContent = image ? nameOf(image) : place ? "Not measured" : "No image chosen";
      remark.textContent = image ? "" : place ? placeName(place) : HINT;
      remark.hidden = Boolean(image);
      const rows = !image ? [] : [...measuredRows(image, { mmPerPx, first_s }),
        ...reasonsNear(image, unmeasured).map(({ what, why }) => [`No ${what}`, why])];
      fill(list, rows.map(([what, words]) => h("div", {}, h("dt", {}, what), h("dd", {}, words))));
      list.hidden = rows.length === 0;
    },
  };
}

const entries = [
  ["is-incoming", "i  incoming"],
  ["is-contact", "c  touching the surface"],
  ["is-rebound", "r  rebound"],
];

function sample(className) {
  const line = svg("line", { class: "photograph-line", x1: 1, y1: 7, x2: 43, y2: 7 });
  return svg("svg", { class: `photograph-sample ${className}`, viewBox: "0 0 44 14", "aria-hidden": "true" }, line);
}

export function createLegend() {
  const scaleWords = h("li");
  const element = h("ul", { class: "photograph-legend", "aria-label": "Lines and letters on the photograph" });
  for (const [className, words] of entries) element.append(h("li", {}, sample(className), words));
  element.append(
    h("li", {}, "number: the flash   *: by hand   ✕: not used"),
    h("li", {}, "hatched: not measured"), scaleWords);
  return {
    element,
    show(enlarged) {
      scaleWords.textContent = enlarged > 1 ?
        `ellipse: one standard deviation of the middle, drawn ${enlarged} times as large` :
        "ellipse: one standard deviation of the middle";
    },
  };
}

/// A button with its keyboard shortcut told.
export function button(words, action, { key, name, className } = {}) {
  return h("button", { type: "button", onclick: action, class: className, "aria-label": name, "aria-keyshortcuts": key,
    title: key ? `${name ?? words} (${key})` : name }, words);
}

export function createTools(stage, ...others) {
  const scale = h("span", { class: "photograph-scale" });
  stage.watch((view) => { scale.textContent = `${Math.round(view.scale * 100)} %`; });
  return h("div", { class: "photograph-tools", role: "toolbar", "aria-label": "Photograph" },
    button("−", () => stage.zoom(1 / stage.stepZoom), { key: "-", name: "Smaller" }),
    button("+", () => stage.zoom(stage.stepZoom), { key: "+", name: "Larger" }),
    button("Fit", stage.fit, { key: "0", name: "Fit: the whole photograph" }), scale, ...others);
}
