// The editor's place on the page: what was found is asked for, and again after each save; leaving with unsaved corrections
// warns.
import { fill, h } from "../parts/dom.js";
import { button } from "../photograph/controls.js";
import { Editor } from "./editor.js";
import { createRequests } from "./requests.js";

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
