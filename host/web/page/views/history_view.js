// All sessions, and all shots of one: newest first, in pages, with the reasons of the rejected.
import { getJson, path, withQuery } from "../live/api.js";
import { fill, h } from "../parts/dom.js";
import { badge, problem, quiet, viewHeading } from "../parts/notices.js";
import { ShotRows } from "../parts/shot_rows.js";
import { table } from "../parts/table.js";
import { count } from "../words/numbers.js";
import { routeTo } from "../words/routes.js";
import { condition } from "../words/shots.js";
import { dateAndTime } from "../words/times.js";

const PAGE = 100;

export function historyView(main, { live, route, signal }) {
  const [session] = route.parts;
  if (session === undefined) return showSessions(main, signal);
  return new SessionHistory(main, live, session, route.query.show ?? "all", signal);
}

async function showSessions(main, signal) {
  const place = h("div", {}, quiet("Reading the sessions."));
  fill(main, viewHeading("History"), place);
  try {
    const sessions = await getJson(path("sessions"), signal);
    fill(place, sessions.length === 0 ? quiet("No session yet.") : sessionsTable(sessions));
  } catch (error) {
    if (error.name !== "AbortError") fill(place, problem(`Sessions: ${error.message}.`));
  }
}

function sessionsTable(sessions) {
  const rows = sessions.map((s) => ({
    head: h("a", { href: routeTo("history", [s.id]) }, s.id),
    cells: [
      s.live ? badge("plain", "live") : s.problem ? badge("caution", "unreadable", s.problem) : "",
      dateAndTime(s.utc),
      s.rig ?? "",
      condition(s),
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
      { title: "begun, UTC", words: true },
      { title: "rig", words: true },
      { title: "spin, angle", words: true },
      { title: "shots" },
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
      h(
        "p",
        { class: "links" },
        h("a", { href: routeTo("history") }, "All sessions"),
        h("a", { href: routeTo("series", [session]) }, "Series"),
        h("a", { href: routeTo("report", [session]) }, "Report"),
      ),
      this.rows.element,
      this.note,
      this.older,
    );
    const observer = new IntersectionObserver(
      (entries) => entries.some((e) => e.isIntersecting) && this.load(),
      { rootMargin: "600px" },
    );
    observer.observe(this.older);
    signal.addEventListener("abort", () => observer.disconnect());
    live.addEventListener("shot", ({ detail }) => detail.session === session && this.arrive(detail), {
      signal,
    });
    live.addEventListener("edited", ({ detail }) => detail.session === session && this.edited(detail.shot), {
      signal,
    });
    live.addEventListener("live", () => live.session === session && this.reload(), { signal });
    this.observer = observer;
    this.load();
  }

  filter(show) {
    const select = h(
      "select",
      {
        onchange: () => {
          this.rows.filter(select.value);
          this.tell();
          this.fillScreen();
        },
      },
      [
        ["all", "all shots"],
        ["counted", "counted"],
        ["rejected", "rejected"],
      ].map(([value, words]) => h("option", { value }, words)),
    );
    select.value = ["counted", "rejected"].includes(show) ? show : "all";
    return h("label", { class: "choice" }, h("span", {}, "Show"), select);
  }

  async load() {
    if (this.loading || !this.more) return;
    this.loading = true;
    try {
      const address = withQuery(path("sessions", this.session, "shots"), {
        limit: PAGE,
        before: this.oldest,
      });
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
