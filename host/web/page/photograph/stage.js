// The window onto a photograph: the picture, a layer for what is drawn on it, zoom and pan by wheel, fingers, mouse and
// keys. A tool (the editor) may take presses and keys first.

import { h, svg } from "../parts/dom.js";
import {
  fitView, isFit, panBy, pinch, resized, reveal, toPhoto, toScreen, widthToLoad, zoomAt,
} from "./view.js";

const stepZoom = 1.25;
const stepPan_px = 60;
const clickSlack_px = { mouse: 2, pen: 4, touch: 8 };

/**
 * photo: {url, width, height}. tool: {begin(at, event) -> drag or null, click(at, event) -> taken, key(event) -> taken},
 * drag: {move(at, event), end(), cancel()}; `at` is a point of the stage in CSS px.
 */
export function createStage(photo, name) {
  const picture = h("img", { class: "photograph-picture", alt: name, draggable: "false" });
  const marks = svg("g", { class: "photograph-marks" });
  const layer = svg("svg", { class: "photograph-layer", role: "group", "aria-label": "What was measured on it" }, marks);
  const element = h("div", { class: "photograph-stage", tabindex: "0", role: "group", "aria-label": `${name}. Zoom with plus and minus, move with the arrow keys` },
  picture, layer);
  const watchers = new Set();
  let size = { width: 1, height: 1 };
  let view = fitView(photo, size);
  let tool = null;
  let loaded = 0;
  let focus = null;
  element.style.aspectRatio = `${photo.width} / ${photo.height}`;
  picture.style.width = `${photo.width}px`;
  picture.style.height = `${photo.height}px`;

  function load() {
    const width = widthToLoad(view, photo, globalThis.devicePixelRatio ?? 1);
    const pixels = width ?? photo.width;
    if (pixels <= loaded) return;
    loaded = pixels;
    const url = new URL(photo.url, document.baseURI);
    if (width) url.searchParams.set("width", width);
    const next = new Image();
    next.addEventListener("load", () => {
      if (pixels === loaded) picture.src = next.src;
    });
    next.addEventListener("error", () => {
      loaded = 0;
      element.dispatchEvent(new CustomEvent("photographfailed"));
    });
    next.src = url.href;
  }

  function show(next) {
    view = next;
    picture.style.transform = `translate(${view.x}px, ${view.y}px) scale(${view.scale})`;
    picture.classList.toggle("is-magnified", view.scale >= 3);
    marks.setAttribute("transform", `translate(${view.x} ${view.y}) scale(${view.scale}) translate(0.5 0.5)`);
    element.classList.toggle("is-fit", isFit(view, photo, size));
    for (const watcher of watchers) watcher(view);
    if (size.width > 1) load();
  }

  /// Where keys and buttons zoom: at what is chosen, as far as it is in sight.
  function zoomPoint() {
    const middle = [size.width / 2, size.height / 2];
    if (!focus) return middle;
    const [x, y] = toScreen(view, focus);
    return x >= 0 && y >= 0 && x <= size.width && y <= size.height ? [x, y] : middle;
  }

  const zoom = (factor, at = zoomPoint()) => show(zoomAt(view, at, factor, photo, size));
  const pan = (dx, dy) => show(panBy(view, dx, dy, photo, size));
  const fit = () => show(fitView(photo, size));

  const observer = new ResizeObserver(() => {
    const now = { width: Math.max(1, element.clientWidth), height: Math.max(1, element.clientHeight) };
    const next = size.width === 1 ? fitView(photo, now) : resized(view, photo, size, now);
    size = now;
    show(next);
  });
  observer.observe(element);

  const pointers = new Map();
  let drag = null;
  let start = null;

  function pointOf(event) {
    const box = element.getBoundingClientRect();
    return [event.clientX - box.left - element.clientLeft, event.clientY - box.top - element.clientTop];
  }

  function panDrag(from) {
    let last = from;
    return {
      move(at) {
        pan(at[0] - last[0], at[1] - last[1]);
        last = at;
      },
      end() {},
      cancel() {},
    };
  }

  function pressed(event) {
    if (event.button !== 0) return;
    const at = pointOf(event);
    pointers.set(event.pointerId, at);
    element.setPointerCapture(event.pointerId);
    if (pointers.size > 1) {
      drag?.cancel();
      drag = start = null;
      return;
    }
    start = { at, moved: false };
    drag = tool?.begin(at, event) ?? panDrag(at);
  }

  function moved(event) {
    if (!pointers.has(event.pointerId)) return;
    const at = pointOf(event);
    const before = [...pointers.values()];
    pointers.set(event.pointerId, at);
    if (pointers.size === 2) {
      show(pinch(view, before, [...pointers.values()], photo, size));
    } else if (drag) {
      if (!start.moved && Math.hypot(at[0] - start.at[0], at[1] - start.at[1]) < (clickSlack_px[event.pointerType] ?? 4)) return;
      start.moved = true;
      drag.move(at, event);
    }
  }

  function released(event) {
    if (!pointers.delete(event.pointerId) || !drag) return;
    const ending = drag;
    const began = start;
    drag = start = null;
    if (event.type === "pointercancel") ending.cancel();
    else if (began.moved) ending.end();
    else {
      ending.cancel();
      tool?.click(began.at, event);
    }
  }

  element.addEventListener("pointerdown", pressed);
  element.addEventListener("pointermove", moved);
  element.addEventListener("pointerup", released);
  element.addEventListener("pointercancel", released);
  element.addEventListener("wheel", (event) => {
    if (event.deltaY > 0 && isFit(view, photo, size)) return;  // the page scrolls on
    event.preventDefault();
    const pixels = event.deltaMode === 1 ? event.deltaY * 20 : event.deltaY;
    zoom(Math.exp(-Math.min(200, Math.max(-200, pixels)) / 400), pointOf(event));
  }, { passive: false });

  const keys = {
    "+": () => zoom(stepZoom), "=": () => zoom(stepZoom), "-": () => zoom(1 / stepZoom), "0": fit,
    ArrowLeft: () => pan(stepPan_px, 0), ArrowRight: () => pan(-stepPan_px, 0),
    ArrowUp: () => pan(0, stepPan_px), ArrowDown: () => pan(0, -stepPan_px),
  };
  element.addEventListener("keydown", (event) => {
    if (tool?.key(event)) return event.preventDefault();
    if (event.ctrlKey || event.metaKey || event.altKey || !keys[event.key]) return undefined;
    if (event.key.startsWith("Arrow") && isFit(view, photo, size)) return undefined;
    event.preventDefault();
    return keys[event.key]();
  });

  return {
    element, marks, zoom, fit, stepZoom,
    view: () => view,
    size: () => size,
    photoPoint: (at) => toPhoto(view, at),
    middle: () => toPhoto(view, [size.width / 2, size.height / 2]),
    reveal: (p) => show(reveal(view, p, 40, photo, size)),
    setFocus(p) {
      focus = p;
    },
    watch: (watcher) => watchers.add(watcher),
    unwatch: (watcher) => watchers.delete(watcher),
    setTool: (next) => { tool = next; },
    destroy: () => observer.disconnect(),
  };
}
