// A series as run charts, a summary, and a table of all its shots: the live one as it grows, or any other.
import { drawAtWidth, legend, RunChart } from "../charts/run_chart.js";
import { getJson, path } from "../live/api.js";
import { attempt, details, fill, h, links, list, quiet, refill, viewHeading } from "../parts/dom.js";
import { QUANTITY, table, UNIT } from "../parts/table.js";
import { ABSENT, fixed, rounded, signed, unitWords } from "../words/numbers.js";
import { routeTo, withQuery } from "../words/routes.js";
import { condition, digitsOf, outlierWords, shotsWords } from "../words/shots.js";

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

  fetch({ spin, angle }) {
    const words = condition({ spin, angle_deg: angle === undefined ? NaN : Number(angle) });
    this.heading.textContent = ["Series", words, "of", this.session].filter(Boolean).join(" ");
    fill(this.summary, quiet("Reading the session."));
    const address = withQuery(path("sessions", this.session, "series"), { spin, angle });
    return attempt(this.summary, `Series of ${this.session}`, async () =>
      this.take(await getJson(address, this.signal)),
    );
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
    const { session } = this;
    refill(
      this.summary,
      summaryTable(this.quantities, series),
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
  const cells = [
    unitWords(q.unit),
    cell(s.mean),
    cell(s.expanded_uncertainty),
    cell(s.total_sd),
    cell(s.scatter_sd),
    cell(s.standard_error),
    cell(s.shared_sd),
    String(s.n),
  ];
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
