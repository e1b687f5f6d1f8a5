// Shots of a session as a table that grows at both ends, filtered by whether they count.
import { h } from "./dom.js";
import { badge } from "./notices.js";
import { rounded, unitWords } from "../words/numbers.js";
import { routeTo } from "../words/routes.js";
import { condition, remarks, verdict } from "../words/shots.js";
import { dateAndTime } from "../words/times.js";

/// Those that tell shots apart at a glance; all are a click away.
const SHOWN = ["vx_td_mps", "vx_lo_mps", "omega_lo_radps", "e", "mu"];

export class ShotRows {
  constructor(session, quantities, show) {
    Object.assign(this, { session, show, shots: new Map() });
    this.quantities = SHOWN.map((name) => quantities.find((q) => q.name === name)).filter(Boolean);
    this.body = h("tbody");
    const heading = (title, unit, words) =>
      h(
        "th",
        { scope: "col", class: words ? "words" : null },
        title,
        unit && h("span", { class: "unit" }, ` ${unit}`),
      );
    this.element = h(
      "div",
      { class: "table-scroll", tabindex: "0", role: "region", "aria-label": "Shots, newest first" },
      h(
        "table",
        { class: "rows shot-rows" },
        h("caption", { class: "visually-hidden" }, "Shots, newest first"),
        h(
          "thead",
          {},
          h(
            "tr",
            {},
            heading("shot"),
            heading("fired, UTC", "", true),
            heading("spin, angle", "", true),
            this.quantities.map((q) => heading(q.label, unitWords(q.unit))),
            heading("counts", "", true),
            heading("why not, flags", "", true),
          ),
        ),
        this.body,
      ),
    );
  }

  append(shots) {
    const fresh = shots.filter((shot) => !this.shots.has(String(shot.name)));
    this.body.append(...fresh.map((shot) => this.add(shot)).filter(Boolean));
  }

  /// A shot that is there already is shown anew in its place.
  prepend(shot) {
    const known = this.shots.get(String(shot.name));
    const row = this.add(shot);
    if (known?.row) return row ? known.row.replaceWith(row) : known.row.remove();
    if (!known) this.shots = new Map([[String(shot.name), { shot, row }], ...this.shots]);
    if (row) this.body.prepend(row);
  }

  clear() {
    this.shots.clear();
    this.body.replaceChildren();
  }

  filter(show) {
    this.show = show;
    this.body.replaceChildren(...[...this.shots.values()].map(({ shot }) => this.add(shot)).filter(Boolean));
  }

  get read() {
    return this.shots.size;
  }

  get shown() {
    return this.body.rows.length;
  }

  /// The row, or null where the shot is not wanted.
  add(shot) {
    const wanted = this.show === "all" || (this.show === "rejected") === !shot.counted;
    const row = wanted ? this.row(shot) : null;
    this.shots.set(String(shot.name), { shot, row });
    return row;
  }

  row(shot) {
    const { level, text } = verdict(shot);
    const number = (q) => {
      const known = shot.values?.[q.name];
      return h(
        "td",
        { class: "number", "data-label": q.label },
        known ? rounded(known.value, known.sd) : "–",
      );
    };
    return h(
      "tr",
      {},
      h(
        "th",
        { scope: "row" },
        h("a", { href: routeTo("shot", [shot.session ?? this.session, shot.name]) }, String(shot.name)),
      ),
      h("td", { class: "words fired" }, dateAndTime(shot.utc)),
      h("td", { class: "words" }, condition(shot)),
      this.quantities.map(number),
      h("td", { class: "words verdict-cell" }, level === "plain" ? text : badge(level, text)),
      h("td", { class: "words reason" }, remarks(shot)),
    );
  }
}
