// A run chart: points with error bars in the order fired, mean and limits, the thesis's row as a band, rejected shots crossed.
// By keyboard it is a slider over the shots; what is under the pointer or chosen by arrow keys is told in words.
import { drawing, fill, h, list, svg } from "../parts/dom.js";
import { fixed, inWords, unitWords } from "../words/numbers.js";
import { meanCells } from "../words/shots.js";
import { labelled, linear, nearestPoint, roundTicks, runChart } from "./run_chart_model.js";

const [HEIGHT, LEFT, RIGHT, TOP, BOTTOM] = [200, 62, 18, 8, 22];
const MANY = 120; // shots, whose marks are small

/// openShot(name) is called for a shot that is clicked, or chosen and confirmed with Enter.
export class RunChart {
  constructor(quantity, openShot) {
    Object.assign(this, { quantity, openShot, chosen: null, width: 0 });
    const unit = unitWords(quantity.unit);
    this.reading = h("p", { class: "reading" });
    this.frame = h("div", {
      class: "plot",
      tabindex: "0",
      role: "slider",
      "aria-label": `${quantity.label}, shot by shot`,
      onkeydown: (e) => this.key(e),
      onpointermove: (e) => this.point(e),
      onpointerleave: () => this.leave(),
      onclick: (e) => this.click(e),
    });
    this.element = h(
      "figure",
      { class: "run-chart" },
      h("figcaption", {}, quantity.label, unit && h("span", { class: "unit" }, ` ${unit}`)),
      this.frame,
      this.reading,
    );
  }

  update(series) {
    this.model = runChart(series, this.quantity.name);
    this.mean = meanCells(series.summary?.quantities?.[this.quantity.name]);
    if (this.chosen) this.chosen = this.model.points[this.chosen.index] ?? null;
    if (this.width) this.draw(this.width);
  }

  draw(width) {
    this.width = width;
    const { points, range } = this.model;
    this.x = linear([-0.5, Math.max(points.length, 1) - 0.5], [LEFT, width - RIGHT]);
    this.y = linear(range, [HEIGHT - BOTTOM, TOP]);
    this.mark = svg("circle", { class: "chosen", r: 8, visibility: "hidden" });
    const parts = [this.thesisBand(), this.axes(width), this.marks(), this.lines(width), this.mark];
    fill(this.frame, drawing(null, width, HEIGHT, ...parts));
    this.describe();
    this.tell(this.chosen);
  }

  axes(width) {
    const { points, range } = this.model;
    const { ticks, decimals } = roundTicks(...range);
    const rows = ticks.map((tick) => [
      stroke("grid", `M${LEFT} ${this.y(tick)}H${width - RIGHT}`),
      svg("text", { x: LEFT - 6, y: this.y(tick) + 4, "text-anchor": "end" }, fixed(tick, decimals)),
    ]);
    const names = labelled(points, (width - LEFT) / 60).map((p) =>
      svg("text", { x: this.x(p.index), y: HEIGHT - 6, "text-anchor": "middle" }, String(p.name).slice(-6)),
    );
    return [...rows, ...names];
  }

  lines(width) {
    const { mean, lower, upper } = this.model;
    const line = (value, kind) =>
      Number.isFinite(value) && stroke(kind, `M${LEFT} ${this.y(value)}H${width - RIGHT}`);
    return [line(lower, "limit"), line(upper, "limit"), line(mean, "mean")];
  }

  thesisBand() {
    const { thesis } = this.model;
    if (!thesis?.isShown) return null;
    const top = this.y(thesis.value + thesis.sd);
    return [
      svg("rect", {
        class: "thesis-band",
        x: LEFT,
        width: Math.max(0, this.width - LEFT - RIGHT),
        y: top,
        height: Math.max(1, this.y(thesis.value - thesis.sd) - top),
      }),
      stroke("thesis-line", `M${LEFT} ${this.y(thesis.value)}H${this.width - RIGHT}`),
    ];
  }

  /// One path for each kind of mark, however many shots there are.
  marks() {
    const { x, y } = this;
    const shown = this.model.points.filter((p) => p.value !== null);
    const path = (points, of) => points.map(of).join("");
    const bars = path(
      shown.filter((p) => p.sd > 0),
      (p) => `M${x(p.index)} ${y(p.value - p.sd)}V${y(p.value + p.sd)}`,
    );
    const dots = path(
      shown.filter((p) => p.counted),
      (p) => `M${x(p.index)} ${y(p.value)}h0`,
    );
    const crosses = path(
      this.model.points.filter((p) => p.value === null || !p.counted),
      (p) => cross(x(p.index), this.height(p)),
    );
    return [
      stroke("bars", bars),
      stroke(shown.length > MANY ? "dots many" : "dots", dots),
      stroke("crosses", crosses),
    ];
  }

  /// Of what has no number: at the bottom.
  height(point) {
    return point.value === null ? HEIGHT - BOTTOM - 5 : this.y(point.value);
  }

  describe() {
    const { points } = this.model;
    const set = (name, value) => this.frame.setAttribute(name, String(value));
    set("aria-valuemin", Math.min(1, points.length));
    set("aria-valuemax", points.length);
    set("aria-valuenow", this.chosen ? this.chosen.index + 1 : points.length);
    set("aria-valuetext", this.chosen ? this.words(this.chosen) : this.summary());
  }

  summary() {
    const { thesis, points } = this.model;
    if (points.length === 0) return "no shot yet";
    const { mean, expanded } = this.mean;
    const words = [
      [`mean ${mean}`, expanded && `± ${expanded}`, unitWords(this.quantity.unit), expanded && "(95 %)"]
        .filter(Boolean)
        .join(" "),
    ];
    if (thesis) {
      const where = thesis.isShown ? "" : `, off the chart ${thesis.isAbove ? "above" : "below"}`;
      words.push(`thesis ${inWords(thesis, "")}${where}`);
    }
    return words.join("; ");
  }

  words(point) {
    const number = point.value === null ? "no number" : inWords(point, this.quantity.unit);
    const state = point.counted ? "" : point.rejected ? `, rejected: ${point.rejected}` : ", not counted";
    return `shot ${point.name}: ${number}${state}`;
  }

  tell(point) {
    this.reading.textContent = point ? this.words(point) : this.summary();
    if (!point) return this.mark.setAttribute("visibility", "hidden");
    this.mark.setAttribute("visibility", "visible");
    this.mark.setAttribute("cx", this.x(point.index));
    this.mark.setAttribute("cy", this.height(point));
  }

  under(event) {
    const place = event.clientX - this.frame.getBoundingClientRect().left;
    const { points } = this.model;
    return nearestPoint(points, ((place - LEFT) / (this.width - LEFT - RIGHT)) * points.length - 0.5);
  }

  point(event) {
    this.tell(this.under(event));
  }

  leave() {
    this.tell(this.chosen);
  }

  click(event) {
    const point = this.under(event);
    if (point && (event.pointerType !== "touch" || this.chosen?.index === point.index))
      return this.openShot(point.name);
    this.choose(point);
  }

  choose(point) {
    this.chosen = point;
    this.describe();
    this.tell(point);
  }

  key(event) {
    const { points } = this.model;
    const at = this.chosen ? this.chosen.index : points.length;
    const steps = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1, PageDown: -10, PageUp: 10 };
    const moves = { Home: 0, End: points.length - 1 };
    for (const [key, step] of Object.entries(steps)) moves[key] = at + step;
    if (event.key === "Enter" && this.chosen) this.openShot(this.chosen.name);
    else if (event.key === "Escape") this.choose(null);
    else if (event.key in moves) this.choose(nearestPoint(points, moves[event.key]));
    else return;
    event.preventDefault();
  }
}

function cross(x, y) {
  return `M${x - 4} ${y - 4}l8 8m0 -8l-8 8`;
}

/// Draws charts anew when their width changes. `signal` ends it.
export function drawAtWidth(charts, signal) {
  const observer = new ResizeObserver((entries) => {
    for (const { target, contentRect } of entries) {
      const chart = charts().find((c) => c.frame === target);
      const width = Math.floor(contentRect.width);
      if (chart && width > 0 && width !== chart.width) chart.draw(width);
    }
  });
  signal.addEventListener("abort", () => observer.disconnect());
  return observer;
}

const stroke = (kind, d) => svg("path", { class: kind, d });
const MARKS = [
  ["counted shot ± its total sd", () => [stroke("bars", "M12 2V18"), stroke("dots", "M12 10h0")]],
  ["rejected", () => stroke("crosses", cross(12, 10))],
  ["mean", () => stroke("mean", "M1 10H23")],
  ["limits of single shots (3 sd, from their moving range)", () => stroke("limit", "M1 10H23")],
  [
    "thesis ± sd",
    () => [
      svg("rect", { class: "thesis-band", x: 1, y: 4, width: 22, height: 12 }),
      stroke("thesis-line", "M1 10H23"),
    ],
  ],
];

/// What the marks of a run chart mean.
export function legend() {
  const items = MARKS.map(([words, marks]) => [drawing(null, 24, 20, marks()), words]);
  return list("legend", items, { "aria-label": "Marks" });
}
