// Buttons of the editor, the list of who measured the photograph and when, and what is told beside them.

import { h } from "../parts/dom.js";
import { button as plainButton } from "../photograph/controls.js";
import { dateAndTime } from "../words/times.js";

const kinds = { auto: "the digitizer", hand: "by hand", corrected: "corrected" };

function digitizationWords({ utc, who, kind }, position, count) {
  const when = utc ? `${dateAndTime(utc)} UTC` : "at a time not known";
  const by = who ? ` by ${who}` : "";
  const counts = position === count - 1 ? ", counts" : "";
  return `${when}: ${kinds[kind] ?? kind}${by}${counts}`;
}

/// What cannot be done just now is marked, not disabled: a button that is loses the focus, and with it the keys.
/// act: {undo, redo, add, surface, save, discard, undoNewest, close}.
export function createActions(act) {
  const button = (words, action, options) => plainButton(words, ({ currentTarget }) => {
    if (currentTarget.getAttribute("aria-disabled") !== "true") action();
  }, options);
  const buttons = {
    undo: button("Undo step", act.undo, { key: "Control+Z" }),
    redo: button("Redo step", act.redo, { key: "Control+Y" }),
    add: button("Add image", act.add, { key: "a" }),
    surface: button("Surface line", act.surface, { name: "Surface line: move its ends" }),
    save: button("Save", act.save, { className: "edit-save", name: "Save these corrections" }),
    discard: button("Discard", act.discard, { name: "Discard what is not saved" }),
    undoNewest: button("Undo the newest correction", act.undoNewest),
    close: button("Close", act.close, { name: "Close the corrections" }),
  };
  for (const name of ["add", "surface"]) buttons[name].setAttribute("aria-pressed", "false");
  const told = h("p", { class: "edit-told", role: "status" });
  const failed = h("p", { class: "edit-problem", role: "alert" });
  const list = h("ol", { class: "edit-digitizations" });
  const head = h("div", { class: "edit-buttons", role: "toolbar", "aria-label": "Correct" },
    buttons.undo, buttons.redo, buttons.add, buttons.surface);
  const foot = h("div", { class: "edit-buttons" }, buttons.save, buttons.discard, buttons.close);
  const history = h("section", { class: "edit-history", "aria-label": "Who measured it" }, h("h3", {}, "Who measured it"),
    list, h("p", { class: "edit-note" }, "The newest counts; the first always stays."), buttons.undoNewest);
  const keys = h("details", { class: "edit-keys" }, h("summary", {}, "Keys"), h("ul", {},
    ...["Tab, Enter: choose an image", "arrows: move it by 0.1 px, with Shift by 1 px", "[ and ]: diameter by 0.1 px, { and } by 1 px",
      ", and . : turn the equator by 0.1°, < and > by 1°", "n: no equator is seen", "Delete: remove", "a: add an image",
      "Control+Z, Control+Y: a step back, forth", "Escape: choose nothing"].map((text) => h("li", {}, text))));

  return {
    head, foot, history, keys, told, failed,
    tell(words) {
      told.textContent = words;
      failed.textContent = "";
    },
    fail: (words) => { failed.textContent = words; },
    /// can: {undo, redo, save, discard, undoNewest}; pressed: {add, surface}.
    show(can, pressed, digitizations) {
      for (const [name, whether] of Object.entries(can)) buttons[name].setAttribute("aria-disabled", String(!whether));
      for (const [name, whether] of Object.entries(pressed)) buttons[name].setAttribute("aria-pressed", String(whether));
      list.replaceChildren(...digitizations.map((each, i) => h("li", {}, digitizationWords(each, i, digitizations.length))));
    },
  };
}
