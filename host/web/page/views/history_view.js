// All sessions, and all shots of one: newest first, in pages, with the reasons of the rejected.
import { getJson, path } from "../live/api.js";
import { attempt, badge, choice, fill, h, links, quiet, viewHeading } from "../parts/dom.js";
import { table } from "../parts/table.js";
import { count, dateAndTime, rounded, unitWords } from "../words/numbers.js";
import { routeTo, withQuery } from "../words/routes.js";
import { condition, remarks, verdict } from "../words/shots.js";

const PAGE = 100;

export function historyView(main, { live, route, signal }) {
  const [session] = route.parts;
  if (session === undefined) return showSessions(main, signal);
  return new SessionHistory(main, live, session, route.query.show ?? "all", signal);
}

function showSessions(main, signal) {
  const place = h("div", {}, quiet("Reading the sessions."));
  fill(main, viewHeading("History"), place);
  return attempt(place, "Sessions", async () => {
    const sessions = await getJson(path("sessions"), signal);
    fill(place, sessions.length === 0 ? quiet("No session yet.") : sessionsTable(sessions));
  });
}

function sessionsTable(sessions) {
  const rows = sessions.map((s) => ({
    head: h("a", { href: routeTo("history", [s.id]) }, s.id),
    cells: [
      s.live ? badge("plain", "live") : s.problem ? badge("caution", "unreadable", s.problem) : "",
      dateAndTime(s.utc),
      s.rig ?? "",
      h("span", { class: "condition" }, condition(s)),
      `${s.counted} of ${s.shots} counted`,
      h("a", { href: routeTo("series", [s.id]), "aria-label": `Series of ${s.id}` }, "series"),
      h("a", { href: routeTo("report", [s.id]), "aria-label": `Report of ${s.id}` }, "report"),
    ],
  }));
  return table(
    "Sessions, newest first",
    [
      { title: "session", words: true },
      { title: "state", hidden: true, words: true },
      ...["begun, UTC", "rig", "condition"].map((title) => ({ title, words: true })),
      "shots",
      { title: "its series", hidden: true, words: true },
      { title: "its report", hidden: true, words: true },
    ],
    rows,
    { className: "rows session-rows" },
  );
}

/// Pages are fetched as one scrolls, or all where a filter looks for few.
class SessionHistory {
  constructor(main, live, session, show, signal) {
    Object.assign(this, { session, signal, more: true, loading: false, oldest: null });
    this.rows = new ShotRows(session, live.quantities, show);
    this.note = h("p", { class: "quiet", role: "status" });
    this.older = h("button", { type: "button", onclick: () => this.load() }, `Show ${PAGE} older`);
    fill(
      main,
      h("div", { class: "view-head" }, viewHeading(`Shots of ${session}`), this.filter(show)),
      links([
        [routeTo("history"), "All sessions"],
        [routeTo("series", [session]), "Series"],
        [routeTo("report", [session]), "Report"],
      ]),
      this.rows.element,
      this.note,
      this.older,
    );
    const seen = (entries) => entries.some((e) => e.isIntersecting) && this.load();
    this.observer = new IntersectionObserver(seen, { rootMargin: "600px" });
    this.observer.observe(this.older);
    signal.addEventListener("abort", () => this.observer.disconnect());
    const on = (kind, act) =>
      live.addEventListener(kind, ({ detail }) => (detail ?? live).session === session && act(detail), { signal });
    on("shot", (shot) => this.arrive(shot));
    on("edited", ({ shot }) => this.edited(shot));
    on("live", () => this.reload());
    this.load();
  }

  filter(show) {
    const options = Object.entries({ all: "all shots", counted: "counted", rejected: "rejected" });
    return choice("Show", options, ["counted", "rejected"].includes(show) ? show : "all", (chosen) => {
      this.rows.filter(chosen);
      this.tell();
      this.fillScreen();
    }).element;
  }

  async load() {
    if (this.loading || !this.more) return;
    this.loading = true;
    try {
      const query = { limit: PAGE, before: this.oldest };
      const address = withQuery(path("sessions", this.session, "shots"), query);
      const { shots, more } = await getJson(address, this.signal);
      this.more = more && shots.length > 0;
      this.oldest = shots.at(-1)?.name ?? this.oldest;
      this.rows.append(shots);
      this.tell();
    } catch (error) {
      if (error.name !== "AbortError") this.note.textContent = `Shots of ${this.session}: ${error.message}.`;
      this.more = false;
    }
    this.loading = false;
    this.fillScreen();
  }

  /// Who looks for few wants them all. An observer tells of a change only: a button that is still in sight is asked after
  /// anew.
  fillScreen() {
    this.older.hidden = !this.more;
    if (!this.more) return;
    if (this.rows.show !== "all") return this.load();
    this.observer.unobserve(this.older);
    this.observer.observe(this.older);
  }

  /// After a time without the host nobody knows what came meanwhile.
  reload() {
    if (this.loading) return;
    Object.assign(this, { more: true, oldest: null });
    this.rows.clear();
    this.load();
  }

  async edited(name) {
    const shot = await getJson(path("sessions", this.session, "shots", name), this.signal).catch(() => null);
    if (shot) this.arrive({ ...shot, name });
  }

  arrive(shot) {
    this.rows.prepend(shot);
    this.tell();
  }

  tell() {
    const { shown, read } = this.rows;
    const of = shown === read ? "" : ` of ${read} read`;
    this.note.textContent =
      read === 0 && !this.more
        ? "No shot yet."
        : `${count(shown, "shot")}${of}${this.more ? ", older ones follow" : ", that is all"}.`;
  }
}

/// Those that tell shots apart at a glance; all are a click away.
const SHOWN = ["vx_td_mps", "vx_lo_mps", "omega_lo_radps", "e", "mu"];

export class ShotRows {
  constructor(session, quantities, show) {
    Object.assign(this, { session, show, shots: new Map() });
    this.quantities = SHOWN.map((name) => quantities.find((q) => q.name === name)).filter(Boolean);
    const columns = [
      "shot",
      { title: "fired, UTC", words: true },
      { title: "condition", words: true },
      ...this.quantities.map((q) => ({ title: q.label, unit: unitWords(q.unit) })),
      { title: "counts", words: true },
      { title: "why not, flags", words: true },
    ];
    const look = { hideCaption: true, className: "rows shot-rows" };
    this.element = table("Shots, newest first", columns, [], look);
    this.body = this.element.querySelector("tbody");
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
      return h("td", { class: "number", "data-label": q.label }, rounded(known?.value, known?.sd));
    };
    const name = String(shot.name);
    return h(
      "tr",
      {},
      h("th", { scope: "row" }, h("a", { href: routeTo("shot", [shot.session ?? this.session, name]) }, name)),
      h("td", { class: "words fired" }, dateAndTime(shot.utc)),
      h("td", { class: "words" }, h("span", { class: "condition" }, condition(shot))),
      this.quantities.map(number),
      h("td", { class: "words verdict-cell" }, level === "plain" ? text : badge(level, text)),
      h("td", { class: "words reason" }, remarks(shot)),
    );
  }
}
