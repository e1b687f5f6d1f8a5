// The last shot as it comes, or any shot of any session: photograph, numbers, what is wrong with it.
import { getJson, path } from "../live/api.js";
import {
  attempt, badge, details, fill, h, links, list, problem, quiet, refill, setAttributes, viewHeading,
} from "../parts/dom.js";
import { afarNumbers } from "../parts/afar.js";
import { essentialsTable, hasNumbers, shotDetails, trainTable } from "../parts/shot_details.js";
import { mountPhotograph } from "../photograph.js";
import { dateAndTime, timeOfDay } from "../words/numbers.js";
import { routeTo, withQuery } from "../words/routes.js";
import { condition, digitizationWords, flagWords, verdict } from "../words/shots.js";

const RETRY_DELAYS_MS = [200, 500, 1000, 2000];

export function shotView(main, { live, route, signal }) {
  const [session, name] = route.parts;
  const view = new ShotView(main, live, signal);
  if (name !== undefined) view.pin(session, name);
  else view.follow();
}

class ShotView {
  constructor(main, live, signal) {
    Object.assign(this, { live, signal, shown: null, series: null, photograph: null });
    this.kept = { open: new Set(), budgetOf: null };
    this.heading = viewHeading("Shot");
    this.facts = h("p", { class: "shot-facts" });
    this.newer = h("p", { class: "newer", role: "status" });
    this.verdict = h("div", { class: "verdict" });
    this.picture = h("div");
    this.numbers = h("div");
    this.more = h("section", { class: "more", "aria-label": "Details" });
    this.notes = h("section", { class: "notes", "aria-label": "Messages" });
    fill(
      main,
      h("div", { class: "view-head" }, this.heading, this.facts, afarButton(signal, () => this.showNumbers())),
      this.newer,
      this.verdict,
      h(
        "div",
        { class: "shot-columns" },
        part("Photograph", "picture", this.picture),
        part("Numbers", "numbers", this.numbers),
      ),
      this.more,
      this.notes,
    );
    signal.addEventListener("abort", () => this.photograph?.destroy());
    live.addEventListener("edited", ({ detail }) => this.edited(detail), { signal });
  }

  pin(session, name) {
    return attempt(this.verdict, `Shot ${name} of ${session}`, async () => {
      const detail = await getJson(path("sessions", session, "shots", name), this.signal);
      this.show({ ...detail, session, name }, detail);
      this.fetchSeries(session, this.shown);
    });
  }

  /// Of the shots like it. Without it the shot is shown alone.
  async fetchSeries(session, { name, dry }) {
    if (dry) return;
    const address = withQuery(path("sessions", session, "series"), { like: name });
    this.series = await getJson(address, this.signal).catch(() => null);
    if (this.series) this.showNumbers();
  }

  follow() {
    const { live, signal } = this;
    const last = () => (live.state.last ? this.arrive(live.state.last) : this.showNone());
    live.addEventListener("shot", ({ detail }) => this.arrive(detail), { signal });
    live.addEventListener("live", last, { signal });
    live.addEventListener("series", () => this.takeSeries(), { signal });
    for (const kind of ["live", "notification"])
      live.addEventListener(kind, () => this.showNotes(), { signal });
    this.takeSeries();
    last();
    this.showNotes();
  }

  /// A new shot never takes the photograph away from under a hand that corrects it.
  arrive(row) {
    if (this.shown && this.photograph?.editing && !isSame(row, this.shown)) {
      const show = () => {
        this.photograph.destroy();
        this.photograph = null;
        this.arrive(this.live.state.last);
      };
      fill(
        this.newer,
        `Shot ${row.name} has come. `,
        h("button", { type: "button", onclick: show }, "Leave the correction and show it"),
      );
      return;
    }
    fill(this.newer);
    this.show(row, this.shown && isSame(row, this.shown) ? this.detail : null);
    if (row.session) this.fetchDetail(row);
  }

  /// What the host has just told may take it a moment to keep.
  async fetchDetail(row, attempt = 0) {
    try {
      const detail = await getJson(path("sessions", row.session, "shots", row.name), this.signal);
      if (isSame(row, this.shown))
        this.show({ ...row, ...detail, session: row.session, name: row.name }, detail);
    } catch (error) {
      if (error.name === "AbortError" || !isSame(row, this.shown)) return;
      if (attempt < RETRY_DELAYS_MS.length)
        setTimeout(() => this.fetchDetail(row, attempt + 1), RETRY_DELAYS_MS[attempt]);
      else fill(this.more, problem(`Details of shot ${row.name}: ${error.message}.`));
    }
  }

  takeSeries() {
    this.series = this.live.state.series;
    this.showNumbers();
  }

  /// `detail`: null while it is on its way; the row's numbers are shown at once.
  show(row, detail) {
    const isNew = !this.shown || !isSame(row, this.shown);
    this.shown = row;
    this.detail = detail;
    this.heading.textContent = `Shot ${row.name}`;
    const utc = row.utc && `${dateAndTime(row.utc)} UTC`;
    const facts = [condition(row), row.regime, digitizationWords(row.digitization), utc].filter(Boolean);
    fill(this.facts, ...facts.map((words) => h("span", {}, words)));
    this.showVerdict();
    this.showNumbers();
    this.showPhotograph(isNew);
    this.showMore(isNew);
  }

  /// Those of the shot before stay, as such, until the new ones are here.
  showMore(isNew) {
    const { detail, shown } = this;
    const waits = !detail && shown.session && isNew;
    this.more.setAttribute("aria-busy", String(Boolean(waits)));
    if (waits && this.more.hasChildNodes()) return;
    refill(this.more, detail && shotDetails(this.live.quantities, detail, this.kept), this.links());
  }

  showVerdict() {
    const { level, text, reason } = verdict(this.shown);
    const flags = this.detail?.flag_words ?? (this.shown.flags ?? []).map(flagWords);
    const told = [this.detail?.problem, ...flags, ...(this.detail?.spatial_words ?? [])];
    const words = [...new Set(told.filter((w) => w && w !== reason))];
    fill(
      this.verdict,
      h("p", {}, badge(level, text), reason && ` ${reason}`),
      list("flags", words, { "aria-label": "Flags" }),
      this.detail?.advice && h("p", { class: "advice" }, h("strong", {}, "What to do: "), this.detail.advice),
    );
  }

  /// A shot without any number is told by its flashes: a dry one, or one that failed.
  showNumbers() {
    const { shown, detail, series } = this;
    if (!shown) return null;
    if (afar && hasNumbers(shown))
      return refill(
        this.numbers,
        afarNumbers(this.live.quantities, shown, this.kept, () => this.showNumbers()),
      );
    if (hasNumbers(shown))
      return refill(this.numbers, essentialsTable(this.live.quantities, shown, series?.summary));
    const words = shown.dry
      ? "A dry shot: its flashes are its result."
      : "Nothing could be measured of this shot.";
    return fill(this.numbers, quiet(words), detail?.train && trainTable(detail.train));
  }

  showPhotograph(isNew) {
    if (isNew) {
      this.photograph?.destroy();
      this.photograph = null;
      const none = "No session is kept, so there is no photograph to show.";
      fill(this.picture, quiet(this.shown.session ? "The photograph is on its way." : none));
    }
    if (!this.detail) return;
    if (this.photograph) return this.photograph.update(this.detail);
    fill(this.picture);
    this.photograph = mountPhotograph(this.picture, {
      session: this.shown.session,
      shot: this.shown.name,
      detail: this.detail,
      canEdit: Boolean(this.live.state.can?.edit),
      onEdited: () => this.fetchDetail(this.shown),
    });
  }

  edited({ session, shot }) {
    if (this.shown && String(shot) === String(this.shown.name) && session === this.shown.session)
      this.fetchDetail(this.shown);
  }

  links() {
    const { session, name, dry } = this.shown;
    if (!session) return null;
    return links([
      [routeTo("history", [session]), "All shots of this session"],
      [routeTo("series", [session], { like: dry ? null : name }), "Its series"],
      [routeTo("shot", [session, name]), "Link to this shot"],
    ]);
  }

  showNotes() {
    const { state, status } = this.live; // the danger stands in the bar, and is told again and again
    const others = (state.notifications ?? []).filter(({ text }) => text !== status?.danger);
    refill(this.notes, notificationList(others));
  }

  showNone() {
    fill(
      this.verdict,
      quiet("No shot yet since strobe was started."),
      h("p", {}, "Earlier ones are in ", h("a", { href: routeTo("history") }, "the history"), "."),
    );
  }
}

function isSame(a, b) {
  return (
    a.session === b.session &&
    String(a.name) === String(b.name) &&
    (a.boot_id ?? "") === (b.boot_id ?? a.boot_id ?? "")
  );
}

function part(title, name, content) {
  return h(
    "section",
    { class: name, "aria-label": title },
    h("h2", { class: "visually-hidden" }, title),
    content,
  );
}

let afar = false;

/// Numbers that fill the screen, to be read from across the room.
function afarButton(signal, onchange) {
  const show = (on) => document.body.classList.toggle("afar", on);
  const toggle = () => {
    afar = !afar;
    show(afar);
    setAttributes(button, { "aria-pressed": String(afar) });
    onchange();
  };
  const look = { class: "afar-button", "aria-pressed": String(afar) };
  const button = h("button", { type: "button", ...look, onclick: toggle }, "Read from afar");
  show(afar);
  signal.addEventListener("abort", () => show(false));
  return button;
}

const SHOWN = 5;

/// What the host has told lately: the newest five, the others on demand.
function notificationList(notifications) {
  if (notifications.length === 0) return null;
  const newest = [...notifications].reverse();
  const item = ({ utc, text }) => h("li", {}, h("time", { datetime: utc }, timeOfDay(utc)), ` ${text}`);
  return [
    h("h2", {}, "Messages"),
    h("ol", { class: "plain-list" }, newest.slice(0, SHOWN).map(item)),
    newest.length > SHOWN &&
      details(
        `${newest.length - SHOWN} earlier`,
        h("ol", { class: "plain-list" }, newest.slice(SHOWN).map(item)),
      ),
  ];
}
