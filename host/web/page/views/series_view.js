// A series as run charts, a summary, and a table of all its shots: the live one as it grows, or any other.
import { getJson, path, withQuery } from "../live/api.js";
import { drawAtWidth, RunChart } from "../charts/run_chart.js";
import { legend } from "../charts/legend.js";
import { fill, h, refill } from "../parts/dom.js";
import { details, problem, quiet, viewHeading } from "../parts/notices.js";
import { pointsTable, summaryTable } from "../parts/series_summary.js";
import { routeTo } from "../words/routes.js";
import { outlierWords } from "../words/series.js";
import { condition } from "../words/shots.js";

export function seriesAddress(session, { spin, angle_deg }) {
  return withQuery(path("sessions", session, "series"), { spin, angle: angle_deg });
}

export function seriesView(main, { live, route, signal }) {
  const [session] = route.parts;
  const view = new SeriesView(main, live, session ?? live.session, signal);
  if (session !== undefined) return view.fetch(route.query);
  const take = () => view.take(live.state.series);
  for (const kind of ["live", "series"]) live.addEventListener(kind, take, { signal });
  return take();
}

class SeriesView {
  constructor(main, live, session, signal) {
    Object.assign(this, { live, session, signal, charts: [], showsAll: false });
    this.heading = viewHeading("Series");
    this.summary = h("section", { "aria-label": "Summary" });
    this.plots = h("section", { class: "run-charts", "aria-label": "Run charts" });
    this.all = h("input", { type: "checkbox", onchange: () => this.show() });
    this.numbers = details("All shots as a table", h("div", { class: "points" }), { id: "points" });
    this.observer = drawAtWidth(() => this.charts, signal);
    fill(
      main,
      h(
        "div",
        { class: "view-head" },
        this.heading,
        h("label", { class: "choice" }, this.all, h("span", {}, "All quantities")),
      ),
      this.summary,
      h("h2", {}, "Shot by shot"),
      legend(),
      this.plots,
      this.numbers,
    );
    this.numbers.addEventListener("toggle", () => this.showPoints());
  }

  async fetch({ spin, angle }) {
    const words = condition({ spin, angle_deg: angle === undefined ? NaN : Number(angle) });
    this.heading.textContent = ["Series", words, "of", this.session].filter(Boolean).join(" ");
    fill(this.summary, quiet("Reading the session."));
    try {
      this.take(
        await getJson(withQuery(path("sessions", this.session, "series"), { spin, angle }), this.signal),
      );
    } catch (error) {
      if (error.name !== "AbortError")
        fill(this.summary, problem(`Series of ${this.session}: ${error.message}.`));
    }
  }

  take(series) {
    this.series = series;
    this.show();
  }

  get quantities() {
    return this.live.quantities.filter((q) => this.all.checked || q.essential);
  }

  show() {
    const { series } = this;
    if (!series?.summary) return fill(this.summary, quiet("No series yet: it begins with the first shot."));
    const outliers = outlierWords(this.live.quantities, series.summary);
    refill(
      this.summary,
      summaryTable(this.quantities, series),
      outliers.length > 0 &&
        h(
          "ul",
          { class: "flags" },
          outliers.map((words) => h("li", {}, words)),
        ),
      this.links(),
    );
    this.showCharts();
    this.showPoints();
  }

  links() {
    if (!this.session) return null;
    return h(
      "p",
      { class: "links" },
      h("a", { href: routeTo("history", [this.session]) }, "All shots"),
      h("a", { href: routeTo("compare", [], { first: this.session }) }, "Compare with another"),
      h("a", { href: routeTo("report", [this.session]) }, "Report"),
    );
  }

  showCharts() {
    const names = this.quantities.map((q) => q.name).join();
    if (names !== this.chartNames) {
      this.chartNames = names;
      this.observer.disconnect();
      this.charts = this.quantities.map((q) => new RunChart(q, (name) => this.openShot(name)));
      for (const chart of this.charts) this.observer.observe(chart.frame);
      fill(
        this.plots,
        this.charts.map((chart) => chart.element),
      );
    }
    for (const chart of this.charts) chart.update(this.series);
  }

  showPoints() {
    if (this.numbers.open && this.series?.points)
      refill(this.numbers.querySelector(".points"), pointsTable(this.quantities, this.series));
  }

  openShot(name) {
    if (this.session) location.hash = routeTo("shot", [this.session, name]);
  }
}
