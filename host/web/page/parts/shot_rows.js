// Shots of a session as a table that grows at both ends, filtered by whether they count.
import { h } from "./dom.js";
import { badge } from "./notices.js";
import { rounded, unitWords } from "../words/numbers.js";
import { routeTo } from "../words/routes.js";
import { condition, flagWords, verdict } from "../words/shots.js";
import { dateAndTime } from "../words/times.js";

/// Those that tell shots apart at a glance; all are a click away.
const SHOWN = ["vx_td_mps", "vx_lo_mps", "omega_lo_radps", "e", "mu"];

export class ShotRows {
  constructor(session, quantities, show) {
    Object.assign(this, { session, show, shown: 0, rows: [] });
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
    this.rows.push(...shots);
    this.body.append(...this.wanted(shots).map((shot) => this.row(shot)));
  }

  prepend(shot) {
    this.rows.unshift(shot);
    this.body.prepend(...this.wanted([shot]).map((s) => this.row(s)));
  }

  clear() {
    this.rows = [];
    this.filter(this.show);
  }

  filter(show) {
    this.show = show;
    this.shown = 0;
    this.body.replaceChildren(...this.wanted(this.rows).map((shot) => this.row(shot)));
  }

  wanted(shots) {
    const chosen = shots.filter(
      (shot) => this.show === "all" || (this.show === "rejected") === !shot.counted,
    );
    this.shown += chosen.length;
    return chosen;
  }

  row(shot) {
    const { level, text, reason } = verdict(shot);
    const flags = (shot.flags ?? []).map(flagWords).join(", ");
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
      h("td", { class: "words reason" }, [reason, flags].filter(Boolean).join("; ")),
    );
  }
}
