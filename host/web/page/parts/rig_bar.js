// On top of every view: danger first, then the connection, what is missing, rig, key, e-stop, and the two buttons that may
// stop it. There is no button that fires.
import { path, postJson } from "../live/api.js";
import { cautions, disconnected, facts, missing, progress } from "../words/rig.js";
import { announce, fill, h, setText, showIfNew } from "./dom.js";

export class RigBar {
  constructor(element, live) {
    this.live = live;
    this.danger = banner("danger", "Danger");
    this.stale = banner("stale", "Not connected");
    this.rig = h("span", { class: "rig" });
    this.facts = h("dl", { class: "facts" });
    this.progress = h("span", { class: "progress" });
    this.missing = h("p", { class: "missing" });
    this.activity = h("p", { class: "activity" });
    this.cautions = h("ul", { class: "cautions" });
    this.answer = h("p", { class: "answer", role: "status" });
    this.stop = stopButton("stop", "Finish shot and stop", "stop", this);
    this.disarm = stopButton("disarm", "Disarm now", "disarm", this);
    fill(
      element,
      this.danger.element,
      this.stale.element,
      h(
        "div",
        { class: "bar-row" },
        h("p", { class: "name" }, h("strong", {}, "strobe"), " ", this.rig, " ", this.progress),
        this.facts,
        h("div", { class: "stops" }, this.disarm, this.stop),
      ),
      h("div", { class: "bar-words" }, this.missing, this.activity, this.cautions, this.answer),
    );
    for (const kind of ["live", "status", "connection"]) live.addEventListener(kind, () => this.update());
    setInterval(() => this.update(), 1000);
    this.update();
  }

  update() {
    const { state, status, connection } = this.live;
    this.danger.say(status?.danger ?? "");
    this.stale.say(disconnected(connection));
    document.body.classList.toggle("is-stale", !connection.connected);
    setText(this.rig, state?.rig ?? "");
    setText(this.progress, progress(status));
    showIfNew(this.facts, facts(status), (all) =>
      all.map(({ name, text, level }) =>
        h("div", { class: `fact ${level}` }, h("dt", {}, name), h("dd", {}, text)),
      ),
    );
    const words = missing(status);
    setText(this.missing, words ? `Cannot fire: ${words}` : "");
    if (!status?.danger) this.tellMissing(words);
    setText(this.activity, status?.activity ?? "");
    showIfNew(this.cautions, cautions(status), (all) => all.map((words) => h("li", {}, words)));
    const can = { ...state?.can, ...status?.can };
    this.stop.hidden = !can.stop;
    this.disarm.hidden = !can.disarm;
  }

  /// Once for each reason, not for each second that it lasts.
  tellMissing(words) {
    const gist = words.replace(/[\d.]+/g, "");
    if (gist !== this.gist && this.gist !== undefined)
      announce(words ? `Cannot fire: ${words}` : "Nothing is missing to fire.");
    this.gist = gist;
  }

  async send(what, words) {
    setText(this.answer, `${words}: sending …`);
    const at = () => new Date().toISOString().slice(11, 19);
    try {
      const { words: told } = await postJson(path(what), {});
      setText(this.answer, told ?? `${words}: told to the host at ${at()} UTC.`);
    } catch (error) {
      setText(
        this.answer,
        `${words}: NOT DONE, ${error.message} (${at()} UTC). Use the console or the e-stop.`,
      );
    }
  }
}

function banner(kind, title) {
  const text = h("span", {});
  const element = h(
    "div",
    { class: `banner ${kind}`, role: "alert", hidden: true },
    h("span", { class: "icon", "aria-hidden": "true" }, "!"),
    h("p", {}, h("strong", {}, `${title}: `), text),
  );
  const say = (words) => {
    setText(text, words);
    element.hidden = words === "";
  };
  return { element, say };
}

function stopButton(kind, words, what, bar) {
  return h(
    "button",
    { type: "button", class: `stop-button ${kind}`, hidden: true, onclick: () => bar.send(what, words) },
    words,
  );
}
