// Zoom buttons above the photograph.
import { h } from "../parts/dom.js";
import { button } from "./controls.js";

export function createTools(stage, ...others) {
  const scale = h("span", { class: "photograph-scale" });
  stage.watch((view) => { scale.textContent = `${Math.round(view.scale * 100)} %`; });
  return h("div", { class: "photograph-tools", role: "toolbar", "aria-label": "Photograph" },
    button("−", () => stage.zoom(1 / stage.stepZoom), { key: "-", name: "Smaller" }),
    button("+", () => stage.zoom(stage.stepZoom), { key: "+", name: "Larger" }),
    button("Fit", stage.fit, { key: "0", name: "Fit: the whole photograph" }), scale, ...others);
}
