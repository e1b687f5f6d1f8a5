// Presses, drags and keys on the photograph while it is corrected: which image or handle they mean, and what they do to
// the edits. The model (model.js) keeps the edits; this module has no state but a drag under way.
import { setAttributes, svg } from "../parts/dom.js";
import { diameterEnds, handleAt, imageAt, lineAngleRad } from "../photograph/geometry.js";

const mouseReach_px = 12;
const touchReach_px = 24;
const DEGREES = 180 / Math.PI;
const steps = { fine: 0.1, coarse: 1 };

/// Points of the photograph where the chosen thing can be taken hold of, by what a drag of it changes.
export function handlesOf(model) {
  if (model.surfaceChosen()) {
    const [left, right] = model.surfaceEnds() ?? [];
    return left ? { "surface-0": left, "surface-1": right } : {};
  }
  const item = model.selectedItem();
  if (!item || item.status === "removed") return {};
  const { centre_px: centre, diameter_px: diameter, equator_rad: equator } = item.image;
  const handles = { centre };
  if (diameter > 0) [handles.rim] = diameterEnds(centre, diameter / 2, (equator ?? 0) - Math.PI / 2);
  if (diameter > 0) [handles.equator] = diameterEnds(centre, 0.66 * diameter, equator ?? 0);
  return handles;
}

const reachOf = (event) => (event.pointerType === "mouse" ? mouseReach_px : touchReach_px);

/// A line has no sense: of the two angles the one nearer to the former, so that its handle stays on its side.
function nearestSense(degrees, former) {
  return degrees + 180 * Math.round((former - degrees) / 180);
}

/// What dragging handle `name` from `from` to `to` (points of the photograph) sets.
export function dragged(name, image, from, to) {
  const centre = image.centre_px;
  if (name === "rim") return { diameter_px: Math.max(2, 2 * Math.hypot(to[0] - centre[0], to[1] - centre[1])) };
  if (name === "equator") return { equator_deg: nearestSense(lineAngleRad(centre, to) * DEGREES, (image.equator_rad ?? 0) * DEGREES) };
  return { centre: [centre[0] + to[0] - from[0], centre[1] + to[1] - from[1]] };
}

const dragWords = { centre: "move", rim: "set the diameter of", equator: "turn the equator of" };

export function createTool({ model, stage, marks, escaped }) {
  function imageUnder(at, reach_px) {
    const items = model.items();
    const found = imageAt(items.map((item) => item.image), stage.photoPoint(at), reach_px / stage.view().scale);
    return found < 0 ? null : items[found];
  }

  function takenHold(at, event) {
    const reach = reachOf(event) / stage.view().scale;
    const name = handleAt(handlesOf(model), stage.photoPoint(at), reach);
    if (name) return name;
    const item = model.selectedItem();
    return item && item.status !== "removed" && imageUnder(at, 0)?.key === item.key ? "centre" : null;
  }

  function drag(at, event) {
    if (model.adding()) return null;
    const name = takenHold(at, event);
    if (!name) return null;
    const from = stage.photoPoint(at);
    const before = model.selectedItem()?.image;
    const surface = model.surfaceEnds();
    return {
      move(now) {
        const to = stage.photoPoint(now);
        if (name.startsWith("surface")) {
          const ends = [...surface];
          ends[Number(name.at(-1))] = to;
          model.attemptSurface(ends);
        } else {
          model.attempt(dragged(name, before, from, to));
        }
      },
      end: () => model.keepAttempt(name.startsWith("surface") ? "move the surface line" : dragWords[name]),
      cancel: () => model.dropAttempt(),
    };
  }

  function click(at, event) {
    if (model.adding()) {
      marks.focus(model.add(stage.photoPoint(at)));
      return true;
    }
    const item = imageUnder(at, reachOf(event));
    model.select(item?.key ?? null);
    if (item) marks.focus(item.key);
    return true;
  }

  /// Up is up on the screen: rows count downwards.
  const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

  function nudge(event) {
    const item = model.selectedItem();
    const step = event.shiftKey ? steps.coarse : steps.fine;
    const [dx, dy] = arrows[event.key];
    const [column, row] = item.image.centre_px;
    model.change({ centre: [column + dx * step, row + dy * step] }, "move", event.repeat);
  }

  function adjust(event) {
    const { diameter_px: diameter, equator_rad: equator } = model.selectedItem().image;
    const turn = (degrees) => model.change({ equator_deg: (equator ?? 0) * DEGREES + degrees }, dragWords.equator, event.repeat);
    const grow = (px) => model.change({ diameter_px: Math.max(2, diameter + px) }, dragWords.rim, event.repeat);
    const done = {
      "[": () => grow(-steps.fine), "]": () => grow(steps.fine), "{": () => grow(-steps.coarse), "}": () => grow(steps.coarse),
      ",": () => turn(-steps.fine), ".": () => turn(steps.fine), "<": () => turn(-steps.coarse), ">": () => turn(steps.coarse),
      n: () => model.toggleEquator(), Delete: () => model.remove(), Backspace: () => model.remove(),
    }[event.key];
    done?.();
    return Boolean(done);
  }


  function key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return false;
    const focused = marks.keyOf(event.target);
    if (event.key === "Escape") return escaped();
    if (event.key === "a") return model.startAdding();
    if (event.key === "Enter" && model.adding()) return marks.focus(model.add(stage.middle())), true;
    if (focused && (event.key === "Enter" || event.key === " ")) return model.select(focused), true;
    const item = model.selectedItem();
    // After a drag the stage has the focus; another image that has it is not meant.
    if (!item || item.status === "removed" || (focused && focused !== item.key)) return false;
    if (arrows[event.key]) return nudge(event), true;
    return adjust(event);
  }

  return { begin: drag, click, key };
}

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
