// The edits of one photograph while a person works on them: what is chosen, what a drag tries, steps back and forth.
// Tells `changed()` whenever what is to be seen differs. Pure but for that.
import { median, surfaceOnPhotograph } from "../photograph/geometry.js";
import { nameOf } from "../photograph/words.js";
import {
  add, correctionsText, isRemoved, itemsOf, measure, measuredOf, noEdits, remove, restore, setSurface,
} from "./state.js";

const inset = 0.06;  // of the photograph's width: where the surface line's ends are offered

/// found: {images, surface_px}; first: edits to begin with; draft: a first step beyond them; photo: {width, height}.
export function createModel({ found, first = noEdits, draft = null, photo, changed }) {
  const undo = createUndo(first);
  if (draft) undo.push(draft, "the corrections that were not saved");
  let attempt = null;
  let selected = null;
  let surfaceChosen = false;
  let adding = false;

  const edits = () => attempt ?? undo.state();
  const items = () => itemsOf(found, edits());
  const itemOf = (key) => items().find((item) => item.key === key) ?? null;
  const selectedItem = () => (selected === null ? null : itemOf(selected));

  function step(next, words, held = false) {
    attempt = null;
    undo.push(next, words, held);
    changed();
  }

  const what = (key) => {
    const image = itemOf(key)?.image;
    return image ? nameOf(image).toLowerCase() : "an image";
  };

  function select(key) {
    selected = key;
    surfaceChosen = adding = false;
    changed();
  }

  function back(words, told) {
    attempt = null;
    if (!selectedItem()) selected = null;
    changed();
    return words === null ? null : `${told}: ${words}`;
  }

  function surfaceEnds() {
    if (edits().surface) return edits().surface.ends;
    const line = surfaceOnPhotograph(found.surface_px, photo);
    if (!line) return null;
    const [a, b] = line[0][0] < line[1][0] ? line : [line[1], line[0]];
    return [inset, 1 - inset].map((t) => [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]);
  }

  return {
    items, edits, selectedItem, surfaceEnds,
    surface_px: () => edits().surface?.ends ?? found.surface_px,
    surfaceChosen: () => surfaceChosen,
    adding: () => adding,
    attempting: () => attempt !== null,
    text: () => correctionsText(found, undo.state()),
    /// With what a drag tries.
    attemptedText: () => correctionsText(found, edits()),
    canUndo: undo.canUndo,
    canRedo: undo.canRedo,
    measured: (key) => measuredOf(edits(), key),
    select,
    chooseSurface() {
      selected = null;
      adding = false;
      surfaceChosen = !surfaceChosen;
      changed();
    },
    startAdding() {
      adding = !adding;
      surfaceChosen = false;
      changed();
      return true;
    },
    stopAdding() {
      adding = false;
      changed();
    },
    /// Where a drag is now; not yet a step.
    attempt(values) {
      attempt = measure(undo.state(), selected, values);
      changed();
    },
    attemptSurface(ends) {
      attempt = setSurface(undo.state(), ends);
      changed();
    },
    keepAttempt(words) {
      if (attempt) step(attempt, surfaceChosen ? words : `${words} ${what(selected)}`);
    },
    dropAttempt() {
      if (!attempt) return;
      attempt = null;
      changed();
    },
    /// held: by a key that is still down: one step with the change before.
    change(values, words, held = false) {
      if (selected !== null) step(measure(undo.state(), selected, values), `${words} ${what(selected)}`, held);
    },
    setSurface(ends) {
      step(setSurface(undo.state(), ends), "move the surface line");
    },
    toggleEquator() {
      const item = selectedItem();
      if (!item) return;
      const { no_equator: none } = measuredOf(undo.state(), selected);
      step(measure(undo.state(), selected, { no_equator: !none }), `${none ? "take back" : "declare"} that no equator is seen, ${what(selected)}`);
    },
    add(centre) {
      const diameter = median(found.images.filter((image) => image.leg !== "contact").map((image) => image.diameter_px).filter((d) => d > 0));
      const next = add(undo.state(), centre, diameter);
      adding = surfaceChosen = false;
      selected = next.key;
      step(next.edits, "add an image");
      return next.key;
    },
    remove() {
      if (selected === null || isRemoved(undo.state(), selected)) return;
      const words = `remove ${what(selected)}`;
      step(remove(undo.state(), selected), words);
      if (!selectedItem()) select(null);
    },
    restore() {
      if (selected !== null) step(restore(undo.state(), selected), `leave as found ${what(selected)}`);
    },
    undo: () => back(undo.undo(), "Undone"),
    redo: () => back(undo.redo(), "Done again"),
    /// All edits at once.
    replace(edits, words) {
      selected = null;
      step(edits, words);
    },
  };
}

/// Steps of an edit, to be taken back and done again. What a key does while it is held is one step with its first press.
export function createUndo(first) {
  let past = [];
  let future = [];
  let now = { state: first, words: "", open: false };
  return {
    state: () => now.state,
    canUndo: () => past.length > 0,
    canRedo: () => future.length > 0,
    /// words: what was done, for the button: "move image of flash 3".
    push(state, words, held = false) {
      if (!(held && now.open && now.words === words)) past.push({ ...now, open: false });
      now = { state, words, open: true };
      future = [];
    },
    /// The words of what is taken back; null: there is nothing.
    undo() {
      if (past.length === 0) return null;
      const undone = now;
      future.push({ ...now, open: false });
      now = past.pop();
      return undone.words;
    },
    redo() {
      if (future.length === 0) return null;
      past.push(now);
      now = future.pop();
      return now.words;
    },
  };
}

const same_px = 1.5;

/// items: [{key, image, status}]; judged: the images of a preview or of the shot. Each judged image serves once.
export function withJudgement(items, judged) {
  const left = [...judged];
  return items.map((item) => {
    if (item.status === "removed") return item;
    const [column, row] = item.image.centre_px;
    const distances = left.map((image) => Math.hypot(image.centre_px[0] - column, image.centre_px[1] - row));
    const nearest = distances.indexOf(Math.min(...distances));
    if (nearest < 0 || distances[nearest] > same_px) return item;
    const [{ flash_index, leg, used, why_not, residual_px, time_s, source }] = left.splice(nearest, 1);
    return { ...item, image: { ...item.image, flash_index, leg, used, why_not, residual_px, time_s, source: item.status === "found" ? source : "hand" } };
  });
}
