// What the lines and letters on the photograph mean, and how many times as large uncertainties are drawn.

import { h, svg } from "../parts/dom.js";

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
