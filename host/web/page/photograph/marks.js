// What was measured, drawn on the photograph: one mark an image (outline, middle, ellipse of uncertainty, equator, flash
// and leg), the surface line, hatched places that were not measured. Marks are kept by key, so that the one that has the
// focus keeps it while it changes.
import { setAttributes, svg } from "../parts/dom.js";
import { diameterEnds, surfaceOnPhotograph, uncertaintyOf } from "./geometry.js";
import { accessibleName, tagOf } from "./words.js";

const legClasses = ["is-incoming", "is-contact", "is-rebound", "is-unknown"];
const legClass = (image) => (["incoming", "contact", "rebound"].includes(image.leg) ? `is-${image.leg}` : "is-unknown");

const lineAttributes = (a, b) => ({ x1: a[0], y1: a[1], x2: b[0], y2: b[1] });

/// A line twice: dark and broad hatched, so that it is seen on white and on black.
const twice = (tag) => ["photograph-casing", "photograph-line"].map((name) => svg(tag, { class: name }));

function createMark(key) {
  const outline = twice("circle");
  const equator = [...twice("line"), ...twice("line")];
  const cross = [...twice("line"), ...twice("line")];
  const ellipse = svg("ellipse", { class: "photograph-ellipse" });
  const focus = svg("circle", { class: "photograph-focus" });
  const tag = svg("text", { class: "photograph-tag" });
  const element = svg("g", { role: "button", tabindex: "0", "data-key": key }, focus, ...outline, ...equator, ellipse, ...cross);

  function drawEquator(image) {
    const seen = image.equator_rad !== null && image.equator_rad !== undefined && image.diameter_px > 0;
    for (const line of equator) setAttributes(line, { visibility: seen ? null : "hidden" });
    if (!seen) return;
    const [a, b] = diameterEnds(image.centre_px, 0.56 * image.diameter_px, image.equator_rad);
    const [c, d] = diameterEnds(image.centre_px, 0.14 * image.diameter_px, image.equator_rad);
    equator.forEach((line, i) => setAttributes(line, i < 2 ? lineAttributes(a, c) : lineAttributes(b, d)));
  }

  function update({ image, status, selected, enlarged, scale }) {
    const [cx, cy] = image.centre_px;
    const r = Math.max(image.diameter_px ?? 0, 0) / 2;
    for (const circle of [...outline, focus]) setAttributes(circle, { cx, cy, r });
    drawEquator(image);
    const arm = 7 / scale;
    cross.forEach((line, i) => setAttributes(line,
      i < 2 ? lineAttributes([cx - arm, cy], [cx + arm, cy]) : lineAttributes([cx, cy - arm], [cx, cy + arm])));
    const sd = uncertaintyOf(image);
    setAttributes(ellipse, sd ? { visibility: null, cx, cy, rx: sd.major * enlarged, ry: sd.minor * enlarged,
      transform: `rotate(${-sd.angleRad * 180 / Math.PI} ${cx} ${cy})` } : { visibility: "hidden" });
    const words = status === "removed" ? "removed" : tagOf(image) + (image.source === "hand" ? "*" : "") + (image.used === false ? " ✕" : "");
    if (tag.textContent !== words) tag.textContent = words;
    setAttributes(tag, { x: cx, y: cy - 12 / scale });
    tag.style.fontSize = `${15 / scale}px`;
    tag.classList.toggle("is-removed", status === "removed");
    element.classList.remove(...legClasses);
    element.classList.add("photograph-image", legClass(image));
    element.classList.toggle("is-unused", image.used === false);
    element.classList.toggle("is-hand", image.source === "hand");
    element.classList.toggle("is-removed", status === "removed");
    element.classList.toggle("is-selected", Boolean(selected));
    setAttributes(element, { "aria-pressed": selected ? "true" : "false",
      "aria-label": accessibleName(image) + (status === "removed" ? ", removed" : "") });
  }
  return { element, tag, update };
}

/// group: an SVG group in the photograph's coordinates.
export function createMarks(group, photo) {
  const surface = twice("line");
  const images = svg("g", { class: "photograph-images" });
  const hatched = svg("g");
  const tags = svg("g", { "aria-hidden": "true" });
  group.append(...surface, images, hatched, tags);
  const drawPlaces = createPlaces(hatched);
  const marks = new Map();
  let shown = { items: [], places: [], surface_px: null, selected: null, enlarged: 1, editing: false };

  function draw(scale) {
    drawPlaces(shown.places, { scale, chosen: shown.selected, pressable: !shown.editing });
    const ends = surfaceOnPhotograph(shown.surface_px, photo);
    for (const line of surface) {
      line.classList.add("is-surface");
      setAttributes(line, ends ? { visibility: null, ...lineAttributes(...ends) } : { visibility: "hidden" });
    }
    const keys = new Set(shown.items.map((item) => item.key));
    for (const [key, mark] of marks) {
      if (keys.has(key)) continue;
      mark.element.remove();
      mark.tag.remove();
      marks.delete(key);
    }
    shown.items.forEach((item, position) => {
      if (!marks.has(item.key)) marks.set(item.key, createMark(item.key));
      const mark = marks.get(item.key);
      mark.update({ ...item, selected: item.key === shown.selected, enlarged: shown.enlarged, scale });
      if (!mark.tag.parentNode) tags.append(mark.tag);
      if (images.children[position] === mark.element) return;
      const focused = document.activeElement === mark.element;
      images.insertBefore(mark.element, images.children[position] ?? null);
      if (focused) mark.element.focus({ preventScroll: true });
    });
  }

  return {
    /// items: [{key, image, status}] in order of time; places: [{centre_px, diameter_px, why}], of keys place-0 …
    show(next, scale) {
      shown = { ...shown, ...next };
      draw(scale);
    },
    rescale: draw,
    focus: (key) => marks.get(key)?.element.focus({ preventScroll: true }),
    keyOf: (target) => target?.closest?.("[data-key]")?.getAttribute("data-key") ?? null,
  };
}

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
