// What can be taken hold of on the photograph while it is corrected: the middle, the rim and the equator's end of the chosen
// image, or the surface line's ends.

import { svg } from "../parts/dom.js";
import { setAttributes } from "../photograph/controls.js";
import { handlesOf } from "./tool.js";

const radius_px = 8;

export function createHandles(stage, model) {
  const group = svg("g", { class: "edit-handles", "aria-hidden": "true" });
  stage.marks.append(group);

  function draw() {
    const scale = stage.view().scale;
    const handles = Object.entries(handlesOf(model));
    while (group.children.length > handles.length) group.lastChild.remove();
    handles.forEach(([name, [cx, cy]], i) => {
      const circle = group.children[i] ?? group.appendChild(svg("circle"));
      setAttributes(circle, { class: `edit-handle is-${name.split("-")[0]}`, cx, cy, r: radius_px / scale });
    });
  }

  stage.watch(draw);
  return {
    draw,
    destroy() {
      stage.unwatch(draw);
      group.remove();
    },
  };
}
