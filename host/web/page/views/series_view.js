// A series as run charts, a summary, and a table of all its shots: the live one as it grows, or any other.
import { drawAtWidth, legend, RunChart } from "../charts/run_chart.js";
import { getJson, path } from "../live/api.js";
import { attempt, details, fill, h, links, list, quiet, refill, viewHeading } from "../parts/dom.js";
import { QUANTITY, table, UNIT } from "../parts/table.js";
import { ABSENT, count, fixed, rounded, signed, unitWords } from "../words/numbers.js";
import { routeTo, withQuery } from "../words/routes.js";
import { digitsOf, keyWords, outlierWords, shotsWords } from "../words/shots.js";

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
    Object.assign(this, { live, session, signal, charts: [] });
    this.heading = viewHeading("Series");
    this.summary = h("section", { "aria-label": "Summary" });
    this.plots = h("section", { class: "run-charts", "aria-label": "Run charts" });
    this.all = h("input", { type: "checkbox", onchange: () => this.show() });
    this.numbers = details("All shots as a table", h("div", { class: "points" }), { id: "points" });
    this.body = h("div", { hidden: true }, h("h2", {}, "Shot by shot"), legend(), this.plots, this.numbers);
    this.observer = drawAtWidth(() => this.charts, signal);
    const more = h("label", { class: "choice" }, this.all, h("span", {}, "All quantities"));
    fill(main, h("div", { class: "view-head" }, this.heading, more), this.summary, this.body);
    this.numbers.addEventListener("toggle", () => this.showPoints());
  }

  fetch(query) {
    fill(this.summary, quiet("Reading the session."));
    const address = withQuery(path("sessions", this.session, "series"), query);
    const read = async () => this.take(await getJson(address, this.signal));
    return attempt(this.summary, `Series of ${this.session}`, read);
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
    const { session } = this;
    const conditions = series?.conditions ?? [];
    const name = conditions.length === 1 && conditions[0].name;
    this.heading.textContent = ["Series", name, session && `of ${session}`].filter(Boolean).join(" ");
    this.body.hidden = !series?.summary;
    if (conditions.length > 1) return fill(this.summary, conditionLinks(series, session));
    if (!series?.summary) return fill(this.summary, quiet("No series yet: it begins with the first shot."));
    refill(
      this.summary,
      summaryTable(this.quantities, series),
      list("flags", series.drift ?? []),
      list("flags", outlierWords(this.live.quantities, series.summary)),
      session &&
        links([
          [routeTo("history", [session]), "All shots"],
          [routeTo("compare", [], { first: session }), "Compare with another"],
          [routeTo("report", [session]), "Report"],
        ]),
    );
    this.showCharts();
    this.showPoints();
  }

  showCharts() {
    const names = this.quantities.map((q) => q.name).join();
    if (names !== this.chartNames) {
      this.chartNames = names;
      this.observer.disconnect();
      this.charts = this.quantities.map((q) => new RunChart(q, (name) => this.openShot(name)));
      for (const chart of this.charts) this.observer.observe(chart.frame);
      fill(this.plots, ...this.charts.map((chart) => chart.element));
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

/// No mean is made of shots that differ, unless it is asked for.
function conditionLinks({ conditions, differ }, session) {
  const link = (words, query) => h("a", { href: routeTo("series", [session], query) }, words);
  const series = conditions.map((one) => [
    link(one.name, { like: one.like }),
    ` ${count(one.counted, "shot")} counted`,
  ]);
  return [
    h("p", {}, `The shots differ in ${keyWords(differ)}. There is a series of each:`),
    list("plain-list links", series),
    h("p", {}, link(`All together: means over ${keyWords(differ)}`, { over: differ.join() })),
  ];
}

export function summaryTable(quantities, series) {
  const { summary } = series;
  const beside = series.thesis ?? null;
  const rows = quantities
    .filter((q) => summary.quantities?.[q.name]?.n > 0)
    .map((q) => summaryRow(q, summary.quantities[q.name], beside));
  const columns = [QUANTITY, UNIT, "mean", "± 95 %", "total sd", "scatter", "std error", "shared", "n"];
  if (beside) columns.push("thesis", "± sd", "off by, its sd");
  return table(`${summary.series || "Series"}: ${shotsWords(summary)}`, columns, rows);
}

function summaryRow(q, s, beside) {
  const sd = digitsOf(s);
  const cell = (number) => (Number.isFinite(number) ? rounded(number, sd) : ABSENT);
  const told = [s.mean, s.expanded_uncertainty, s.total_sd, s.scatter_sd, s.standard_error, s.shared_sd];
  const cells = [unitWords(q.unit), ...told.map(cell), String(s.n)];
  return { head: q.label, cells: beside ? [...cells, ...thesisCells(beside[q.name], s.mean)] : cells };
}

function thesisCells(row, mean) {
  if (!row || !Number.isFinite(row.value)) return ["", "", ""];
  const off = Number.isFinite(mean) && row.sd > 0 ? signed((mean - row.value) / row.sd, 1) : "";
  return [fixed(row.value, 2), `± ${fixed(row.sd, 2)}`, off];
}

export function pointsTable(quantities, series) {
  const number = (known) => (Number.isFinite(known?.value) ? rounded(known.value, known.sd) : ABSENT);
  const rows = series.points.map((point) => ({
    head: point.name,
    class: point.counted ? null : "rejected",
    cells: [
      ...quantities.map((q) => number(point.values?.[q.name])),
      point.counted ? "counted" : `rejected: ${point.rejected ?? "not counted"}`,
    ],
  }));
  const columns = [
    "shot",
    ...quantities.map((q) => ({ title: q.label, unit: unitWords(q.unit) })),
    { title: "counts", words: true },
  ];
  return table("All shots of the series", columns, rows, { hideCaption: true });
}
