// Places that looked like a ball and were not measured: hatched, and each says why.
import { svg } from "../parts/dom.js";
import { setAttributes } from "./controls.js";

const SPACING_PX = 10;
const MIN_RADIUS_PX = 12;
let patterns = 0;

/// What is said of a place.
export const placeName = (place) => `Not measured: ${place.why}`;

export function createPlaces(group) {
  const id = `photograph-hatch-${++patterns}`;
  const stripe = svg("path", { class: "photograph-stripe" });
  const pattern = svg("pattern", { id, patternUnits: "userSpaceOnUse" }, stripe);
  const circles = svg("g");
  group.append(svg("defs", {}, pattern), circles);

  function circleOf(position) {
    return circles.children[position] ?? circles.appendChild(
      svg("circle", { class: "photograph-unmeasured", "data-key": `place-${position}`, fill: `url(#${id})` }));
  }

  /// chosen: the key of the one that is; pressable: not while the photograph is corrected.
  return (places, { scale, chosen, pressable }) => {
    const step = SPACING_PX / scale;
    setAttributes(pattern, { width: step, height: step });
    setAttributes(stripe, { d: `M0 ${step} L${step} 0`, "stroke-width": 1.6 / scale });
    while (circles.children.length > places.length) circles.lastChild.remove();
    places.forEach((place, position) => {
      const key = `place-${position}`;
      setAttributes(circleOf(position), { cx: place.centre_px[0], cy: place.centre_px[1], r: Math.max(place.diameter_px / 2, MIN_RADIUS_PX / scale),
        role: pressable ? "button" : "img", tabindex: pressable ? "0" : null, "aria-label": placeName(place),
        "aria-pressed": pressable ? String(key === chosen) : null });
      circleOf(position).classList.toggle("is-selected", key === chosen);
    });
  };
}
