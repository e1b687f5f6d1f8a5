// Corrections of one photograph as a person makes them: each step is asked of the host as a preview, so that the readout is
// seen to change; saved, it is what `strobe shot --edit` makes of the same text.
import { fill, h } from "../parts/dom.js";
import { button } from "../photograph/beside.js";
import { enlargement, hatchedPlaces, inTime } from "../photograph/geometry.js";
import { createActions, createFields, createTable } from "./controls.js";
import { createNewestOnly, createRequests, keepDraft, readDraft } from "./host.js";
import { createModel, withJudgement } from "./model.js";
import { correctionsText, editsFromList } from "./state.js";
import { createHandles, createTool } from "./tool.js";

export class Editor {
  /// host: what mount.js gives. answer: the host's, of what was found and which corrections count.
  constructor(host, { found, corrections }) {
    const { edits: saved, lost } = editsFromList(found, corrections);
    const draft = readDraft(host.session, host.shot, found);
    Object.assign(this, { host, found, saved, savedText: correctionsText(found, saved), judged: host.detail().images,
      quantities: [], asked: null, busy: false, ended: new AbortController() });
    this.model = createModel({ found, first: saved, draft, photo: host.photo, changed: () => this.changed() });
    this.table = createTable();
    this.fields = createFields(this.model);
    this.handles = createHandles(host.stage, this.model);
    this.actions = createActions(this.acts());
    this.preview = this.createPreview();
    this.show();
    this.changed();
    if (draft) this.actions.tell("Corrections that were not saved are here again.");
    if (lost.length > 0)
      this.actions.fail(`Of the corrections that count, ${lost.length} no longer mean an image that is found: saved again, they are left out.`);
    this.askQuantities();
  }

  acts() {
    const { model } = this;
    return {
      undo: () => this.tellStep(model.undo()), redo: () => this.tellStep(model.redo()), add: model.startAdding, surface: model.chooseSurface,
      save: () => this.save(), discard: () => model.replace(this.saved, "discard what was not saved"), undoNewest: () => this.undoNewest(),
      close: () => this.close(),
    };
  }

  createPreview() {
    return createNewestOnly({
      ask: this.host.requests.preview,
      busy: (whether) => this.table.tell(whether ? "Measuring …" : ""),
      answered: (answer) => {
        this.judged = answer.images ?? this.judged;
        this.table.show(answer, this.quantities);
        this.draw();
      },
      failed: (error) => this.table.fail(`No readout for these corrections: ${error.message}. They are kept.`),
    });
  }

  show() {
    const { host, actions } = this;
    fill(host.under, this.table.element);
    fill(host.element, actions.head, this.fields.element, actions.foot, actions.told, actions.failed, actions.keys, actions.history);
    host.stage.element.classList.add("is-correcting");
    host.stage.setTool(createTool({ model: this.model, stage: host.stage, marks: host.marks, escaped: () => this.escape() }));
    for (const part of [host.stage.element, host.element])
      part.addEventListener("keydown", (event) => this.undoKey(event), { signal: this.ended.signal });
  }

  async askQuantities() {
    try {
      this.quantities = await this.host.requests.quantities();
      this.asked = null;
      this.ask();
    } catch (error) {
      this.table.fail(`The readout's names are missing: ${error.message}.`);
    }
  }

  unsaved() { return this.model.text() !== this.savedText; }

  tellStep(words) {
    if (words) this.actions.tell(words);
  }

  changed() {
    this.draw();
    if (!this.model.attempting()) this.keep();
    this.ask();
  }

  /// A step is made.
  keep() {
    this.actions.tell("");
    keepDraft(this.host.session, this.host.shot, this.found, this.unsaved() ? this.model.edits() : null);
  }

  /// The preview of what is to be seen, unless it is asked for already.
  ask() {
    const text = this.model.attemptedText();
    if (text === this.asked || this.ended.signal.aborted) return;
    this.asked = text;
    if (text !== "" && text !== this.savedText) {
      this.preview.want(text);
      return;
    }
    this.preview.forget();
    this.table.clear();
    this.judged = this.host.detail().images;
    this.table.tell(text === this.savedText ? "" : "Nothing is corrected any more: to go back to what was found, undo the newest correction.");
  }

  draw() {
    if (this.ended.signal.aborted) return;
    const { host, model, found } = this;
    const items = withJudgement(model.items(), this.judged);
    const chosen = items.find((item) => item.key === model.selectedItem()?.key);
    const enlarged = enlargement(found.images);
    host.stage.setFocus(chosen?.image.centre_px ?? null);
    host.marks.show({ items: inTime(items.map((item) => item.image)).map((position) => items[position]), places: hatchedPlaces(found),
      surface_px: model.surface_px(), editing: true, selected: chosen?.key ?? null, enlarged }, host.stage.view().scale);
    host.legend.show(enlarged);
    host.stage.element.classList.toggle("is-adding", model.adding());
    this.handles.draw();
    this.fields.show(chosen);
    this.showActions();
  }

  showActions() {
    const { model, busy } = this;
    const { digitizations } = this.host.detail();
    const unsaved = this.unsaved();
    this.actions.show({ undo: model.canUndo(), redo: model.canRedo(), save: unsaved && model.text() !== "" && !busy, discard: unsaved && !busy,
      undoNewest: digitizations.at(-1)?.kind === "corrected" && !unsaved && !busy },
    { add: model.adding(), surface: model.surfaceChosen() }, digitizations);
  }

  /// A number that is being typed has its own undoing.
  undoKey(event) {
    if (!(event.ctrlKey || event.metaKey) || event.target.matches("input[type=number]")) return;
    const key = event.key.toLowerCase();
    if (key !== "z" && key !== "y") return;
    event.preventDefault();
    this.tellStep(key === "z" && !event.shiftKey ? this.model.undo() : this.model.redo());
  }

  escape() {
    if (this.model.adding()) this.model.stopAdding();
    else if (this.model.selectedItem() || this.model.surfaceChosen()) this.model.select(null);
    else return false;
    return true;
  }

  /// What the host is asked to do; whatever it answers, the edits stay until it is done.
  async act(doing, failing, ask, done) {
    this.busy = true;
    this.actions.tell(doing);
    this.draw();
    try {
      await ask();
      await done();
    } catch (error) {
      this.actions.tell("");
      this.actions.fail(`${failing}: ${error.message}. Nothing is lost: try again.`);
    }
    this.busy = false;
    this.draw();
  }

  save() {
    const { host, model } = this;
    const text = model.text();
    return this.act("Saving …", "Not saved", () => host.requests.save(text), () => {
      const goneOn = model.text() === text ? null : model.edits();
      keepDraft(host.session, host.shot, this.found, goneOn);
      return host.again("Saved: these corrections count from now on.");
    });
  }

  undoNewest() {
    const { host } = this;
    return this.act("Undoing …", "Not undone", () => host.requests.undo(),
      () => host.again("The newest correction is taken back; the one before it counts again."));
  }

  close() {
    if (this.unsaved()) this.actions.fail("There are corrections that are not saved: save or discard them first.");
    else this.host.close();
  }

  destroy() {
    this.ended.abort();
    this.preview.forget();
    this.handles.destroy();
    this.host.stage.element.classList.remove("is-adding", "is-correcting");
  }
}

const OTHERS = "Somebody else corrected this shot meanwhile. Your corrections are kept; saved, they replace theirs, which stay in the list.";

/// side: where the editor's controls go; under: where the comparison goes. ended(): closed by the person; edited(): the
/// shot's detail is to be fetched anew.
export function mountEditor({ session, shot, detail: first, photo, stage, marks, legend, side, under, ended, edited }) {
  const element = h("section", { class: "edit", "aria-label": "Corrections by hand" });
  const requests = createRequests(session, shot);
  let detail = first;
  let editor = null;
  let gone = false;
  let ours = false;  // the next change of the shot is this editor's own
  side.append(element);
  const host = {
    session, shot, photo, stage, marks, legend, element, under,
    requests: { ...requests, save: ownChange(requests.save), undo: ownChange(requests.undo) },
    detail: () => detail,
    close: ended,
    async again(words) {
      edited?.();
      await begin();
      editor?.actions.tell(words);
    },
  };

  function ownChange(ask) {
    return async (...what) => {
      ours = true;
      try {
        return await ask(...what);
      } catch (error) {
        ours = false;
        throw error;
      }
    };
  }

  async function begin() {
    try {
      const answer = await requests.corrections();
      if (gone) return;
      editor?.destroy();
      editor = new Editor(host, answer);
    } catch (error) {
      if (gone) return;
      editor?.destroy();
      editor = null;
      fill(element, h("p", { class: "edit-problem", role: "alert" }, `It cannot be corrected now: ${error.message}.`),
        button("Try again", start), button("Close", ended));
    }
  }

  function start() {
    fill(element, h("p", { role: "status" }, "Asking what was found …"));
    begin();
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
      const changed = next.digitizations.length !== detail.digitizations.length;
      const byOthers = changed && !ours;
      if (changed) ours = false;
      detail = next;
      editor?.draw();
      if (byOthers && unsaved()) editor.actions.fail(OTHERS);
      else if (byOthers) begin();
    },
    destroy() {
      gone = true;
      window.removeEventListener("beforeunload", warn);
      editor?.destroy();
      element.remove();
      fill(under);
    },
  };
}
