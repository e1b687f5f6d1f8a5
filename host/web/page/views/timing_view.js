// How exactly the rig keeps its times: histograms since the firmware started, in words and bars.
import { roundTicks } from "../charts/run_chart_model.js";
import { getJson, path } from "../live/api.js";
import { fill, h, list, problem, quiet, showIfNew, svg, viewHeading } from "../parts/dom.js";
import { table } from "../parts/table.js";
import { fixed } from "../words/numbers.js";
import { clockWords, spread, TIMINGS } from "../words/rig.js";

const REFRESH_MS = 5000;

export function timingView(main, { live, signal }) {
  const place = h("div", {}, quiet("Asking the host."));
  fill(main, viewHeading("Timing"), place);
  let isShown = false;
  const load = async () => {
    if (live.state.status?.state === "never_heard") return fill(place, quiet("No firmware was heard yet."));
    try {
      showIfNew(place, await getJson(path("timing"), signal), content);
      isShown = true;
    } catch (error) {
      if (error.name !== "AbortError" && !isShown) fill(place, problem(`Timing: ${error.message}.`));
    }
  };
  load();
  const timer = setInterval(() => !document.hidden && load(), REFRESH_MS);
  signal.addEventListener("abort", () => clearInterval(timer));
  live.addEventListener("shot", load, { signal });
}

function content({ timing, clock, rejected, unverified }) {
  const known = TIMINGS.filter(({ key }) => timing?.[key]?.n > 0);
  const ignored = [...counts(rejected, "commands ignored"), ...counts(unverified, "packets ignored")];
  return [
    known.length > 0 &&
      quiet(
        "In microseconds, since the firmware started. Heights are logarithmic; the first and the last bar also count what lies beyond them.",
      ),
    known.length === 0
      ? quiet("No flash was fired yet since the firmware started.")
      : h(
          "div",
          { class: "timings" },
          known.map((t) => section(t, timing[t.key])),
        ),
    known.length > 0 && figures(known, timing),
    h("h2", {}, "Clock"),
    h("p", {}, clockWords(clock) || "not known"),
    ignored.length > 0 && [h("h2", {}, "Ignored"), list("plain-list", ignored)],
  ];
}

function section({ title, words }, values) {
  return h(
    "section",
    { class: "timing" },
    h("h2", {}, title),
    h("p", { class: "quiet" }, `${words[0].toUpperCase()}${words.slice(1)}.`),
    histogram(values),
    h("p", {}, spread(values)),
  );
}

const FIGURES = { mean: "mean", sd: "sd", min: "smallest", p50: "50 %", p99: "99 %", p99_9: "99.9 %", max: "largest" };

function figures(known, timing) {
  const rows = known.map(({ key, title }) => ({
    head: title,
    cells: [...Object.keys(FIGURES).map((name) => fixed(timing[key][name], 2)), String(timing[key].n)],
  }));
  const columns = [{ title: "time", hidden: true }, ...Object.values(FIGURES), "n"];
  return table("In microseconds", columns, rows);
}

function counts(object, what) {
  return Object.entries(object ?? {})
    .filter(([, n]) => n > 0)
    .map(([why, n]) => `${what}: ${n} ${why.replaceAll("_", " ")}`);
}

const [WIDTH, HEIGHT, BOTTOM, SIDE] = [420, 130, 20, 24];

/// Heights between 0 and 1: log(n) over the largest's, at least a sliver for a single one.
export function barHeights(bins) {
  const most = Math.max(...bins, 1);
  return bins.map((n) => (n <= 0 ? 0 : most === 1 ? 1 : 0.1 + (0.9 * Math.log(n)) / Math.log(most)));
}

export function histogram({ bin_first: first, bin_width: width, bins }) {
  if (!bins?.length || !(width > 0)) return null;
  const last = first + width * bins.length;
  const x = (value) => SIDE + ((value - first) / (last - first)) * (WIDTH - 2 * SIDE);
  const floor = HEIGHT - BOTTOM;
  const bars = barHeights(bins).map(
    (height, i) =>
      height > 0 &&
      svg("rect", {
        class: "bar-of-counts",
        x: x(first + i * width) + 0.5,
        y: floor - height * (floor - 6),
        height: height * (floor - 6),
        width: Math.max(1, x(first + (i + 1) * width) - x(first + i * width) - 1),
      }),
  );
  const { ticks, decimals } = roundTicks(first, last, 5);
  const labels = ticks.map((tick) =>
    svg("text", { x: x(tick), y: HEIGHT - 5, "text-anchor": "middle" }, fixed(tick, decimals)),
  );
  return svg(
    "svg",
    { class: "histogram", viewBox: `0 0 ${WIDTH} ${HEIGHT}`, "aria-hidden": "true" },
    svg("path", { class: "axis", d: `M${SIDE} ${floor}H${WIDTH - SIDE}` }),
    bars,
    labels,
  );
}
