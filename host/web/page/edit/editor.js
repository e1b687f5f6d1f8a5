// Corrections of a photograph by mouse, touch and keyboard: each step is asked of the host as a preview, so that the
// readout is seen to change; saved, it is what `strobe shot --edit` makes of the same text.

import { createActions } from "./actions.js";
import { keepDraft, readDraft } from "./draft.js";
import { createFields } from "./fields.js";
import { createHandles } from "./handles.js";
import { withJudgement } from "./judgement.js";
import { createModel } from "./model.js";
import { createNewestOnly } from "./preview.js";
import { createRequests } from "./requests.js";
import { createTable } from "./table.js";
import { createTool } from "./tool.js";
import { correctionsText, editsFromList } from "./toml.js";
import { fill, h } from "../parts/dom.js";
import { button } from "../photograph/controls.js";
import { enlargement, hatchedPlaces, inTime } from "../photograph/geometry.js";

/// {found, saved: edits, lost} of the host's answer.
function readCorrections({ found, corrections }) {
  const { edits, lost } = editsFromList(found, corrections);
  return { found, saved: edits, lost };
}

function createEditor(host, { found, saved, lost }) {
  const { session, shot, photo, stage, marks, legend, requests } = host;
  const savedText = correctionsText(found, saved);
  const draft = readDraft(session, shot, found);
  const model = createModel({ found, first: saved, draft, photo, changed });
  const table = createTable();
  const fields = createFields(model);
  const handles = createHandles(stage, model);
  const actions = createActions({
    undo: () => tellStep(model.undo()), redo: () => tellStep(model.redo()), add: model.startAdding, surface: model.chooseSurface,
    save, discard: () => model.replace(saved, "discard what was not saved"), undoNewest, close,
  });
  let judged = host.detail().images;
  let quantities = [];
  let asked = null;
  let busy = false;

  const unsaved = () => model.text() !== savedText;
  const tellStep = (words) => words && actions.tell(words);

  const preview = createNewestOnly({
    ask: requests.preview,
    busy: (whether) => table.tell(whether ? "Measuring …" : ""),
    answered(answer) {
      judged = answer.images ?? judged;
      table.show(answer, quantities);
      draw();
    },
    failed: (error) => table.fail(`No readout for these corrections: ${error.message}. They are kept.`),
  });

  function ask() {
    const text = model.text();
    if (text === asked) return;
    asked = text;
    keepDraft(session, shot, found, text === savedText ? null : model.edits());
    if (text !== "" && text !== savedText) return preview.want(text);
    preview.forget();
    table.clear();
    judged = host.detail().images;
    table.tell(text === savedText ? "" : "Nothing is corrected any more: to go back to what was found, undo the newest correction.");
  }

  function draw() {
    const items = withJudgement(model.items(), judged);
    const images = items.map((item) => item.image);
    const enlarged = enlargement(found.images);
    stage.setFocus(model.selectedItem()?.image.centre_px ?? null);
    marks.show({ items: inTime(images).map((position) => items[position]), places: hatchedPlaces({ images: found.images, unmeasured: found.unmeasured ?? host.detail().unmeasured }), surface_px: model.surface_px(), editing: true,
      selected: model.selectedItem()?.key ?? null, enlarged }, stage.view().scale);
    legend.show(enlarged);
    handles.draw();
    fields.show(items.find((item) => item.key === model.selectedItem()?.key));
    const corrected = host.detail().digitizations.at(-1)?.kind === "corrected";
    actions.show({ undo: model.canUndo(), redo: model.canRedo(), save: unsaved() && model.text() !== "" && !busy, discard: unsaved() && !busy,
      undoNewest: corrected && !unsaved() && !busy }, { add: model.adding(), surface: model.surfaceChosen() }, host.detail().digitizations);
    stage.element.classList.toggle("is-adding", model.adding());
    stage.element.classList.add("is-correcting");
  }

  function changed() {
    draw();
    if (model.attempting()) return;
    actions.tell("");
    ask();
  }

  /// A number that is being typed has its own undoing.
  function undoKey(event) {
    if (!(event.ctrlKey || event.metaKey) || event.target.matches("input[type=number]")) return;
    const key = event.key.toLowerCase();
    if (key !== "z" && key !== "y") return;
    event.preventDefault();
    tellStep(key === "z" && !event.shiftKey ? model.undo() : model.redo());
  }

  /// What the host is asked to do; whatever it answers, the edits stay until it is done.
  async function act(doing, failing, done) {
    busy = true;
    actions.tell(doing);
    draw();
    try {
      await done();
    } catch (error) {
      actions.tell("");
      actions.fail(`${failing}: ${error.message}. Nothing is lost: try again.`);
    }
    busy = false;
    draw();
  }

  function save() {
    const text = model.text();
    return act("Saving …", "Not saved", async () => {
      await requests.save(text);
      if (model.text() === text) keepDraft(session, shot, found, null);
      await host.again("Saved: these corrections count from now on.", model.text() === text ? null : model.edits());
    });
  }

  function undoNewest() {
    return act("Undoing …", "Not undone", async () => {
      await requests.undo();
      await host.again("The newest correction is taken back; the one before it counts again.", null);
    });
  }

  function close() {
    if (unsaved()) return actions.fail("There are corrections that are not saved: save or discard them first.");
    return host.close();
  }

  const tool = createTool({ model, stage, marks, escaped() {
    if (model.adding()) model.stopAdding();
    else if (model.selectedItem() || model.surfaceChosen()) model.select(null);
    else return false;
    return true;
  } });
  fill(host.under, table.element);
  fill(host.element, actions.head, fields.element, actions.foot, actions.told, actions.failed, actions.keys, actions.history);
  stage.setTool(tool);
  const undoKeys = new AbortController();
  for (const part of [stage.element, host.element]) part.addEventListener("keydown", undoKey, { signal: undoKeys.signal });
  requests.quantities().then((list) => {
    quantities = list;
    asked = null;
    ask();
  }, (error) => table.fail(`The readout's names are missing: ${error.message}`));
  changed();
  if (draft) actions.tell("Corrections that were not saved are here again.");
  if (lost.length > 0) actions.fail(`${lost.length} earlier correction${lost.length > 1 ? "s" : ""} no longer mean any image that is found, and would be left out.`);
  return {
    unsaved, draw, tell: actions.tell,
    fail: actions.fail,
    destroy() {
      preview.forget();
      handles.destroy();
      undoKeys.abort();
    },
  };
}

/// side: where the editor's controls go; under: where the comparison goes. ended(): closed by the person; edited(): the shot's detail is to be fetched anew.
export function mountEditor({ session, shot, detail: first, photo, stage, marks, legend, side, under, ended, edited }) {
  const element = h("section", { class: "edit", "aria-label": "Corrections by hand" });
  const requests = createRequests(session, shot);
  let detail = first;
  let editor = null;
  let gone = false;
  side.append(element);
  const host = {
    session, shot, photo, stage, marks, legend, element, under, requests,
    detail: () => detail,
    close: ended,
    async again(words, edits) {
      edited?.();
      await begin(edits);
      editor?.tell(words);
    },
  };

  async function begin(edits = null) {
    const answer = readCorrections(await requests.corrections());
    if (gone) return;
    editor?.destroy();
    if (edits) keepDraft(session, shot, answer.found, edits);
    editor = createEditor(host, answer);
  }

  function start() {
    fill(element, h("p", { role: "status" }, "Asking what was found …"));
    begin().catch((error) => {
      fill(element, h("p", { class: "edit-problem", role: "alert" }, `It cannot be corrected now: ${error.message}.`),
        button("Try again", start), button("Close", ended));
    });
  }

  const unsaved = () => editor?.unsaved() ?? false;
  const warn = (event) => {
    if (unsaved()) event.preventDefault();
  };
  window.addEventListener("beforeunload", warn);
  start();
  return {
    unsaved,
    update(next) {
      const others = next.digitizations.length !== detail.digitizations.length && unsaved();
      detail = next;
      editor?.draw();
      if (others) editor.fail("Somebody else corrected this shot meanwhile. Your corrections are kept; saved, they replace theirs, which stay below.");
    },
    destroy() {
      gone = true;
      window.removeEventListener("beforeunload", warn);
      stage.element.classList.remove("is-adding", "is-correcting");
      editor?.destroy();
      element.remove();
      fill(under);
    },
  };
}
