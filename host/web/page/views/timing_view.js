// How exactly the rig keeps its times: histograms since the firmware started, in words and bars.
import { getJson, path } from "../live/api.js";
import { histogram } from "../charts/histogram.js";
import { fill, h, refill } from "../parts/dom.js";
import { problem, quiet, viewHeading } from "../parts/notices.js";
import { table } from "../parts/table.js";
import { fixed } from "../words/numbers.js";
import { clockWords, spread, TIMINGS } from "../words/timing.js";

const REFRESH_MS = 5000;

export function timingView(main, { live, signal }) {
  const place = h("div", {}, quiet("Asking the host."));
  fill(main, viewHeading("Timing"), place);
  let shown = "";
  const load = async () => {
    if (live.state.status?.state === "never_heard") return fill(place, quiet("No firmware was heard yet."));
    try {
      const timing = await getJson(path("timing"), signal);
      const text = JSON.stringify(timing);
      if (text !== shown) refill(place, content(timing));
      shown = text;
    } catch (error) {
      if (error.name !== "AbortError" && shown === "") fill(place, problem(`Timing: ${error.message}.`));
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
    ignored.length > 0 && [
      h("h2", {}, "Ignored"),
      h(
        "ul",
        { class: "plain-list" },
        ignored.map((words) => h("li", {}, words)),
      ),
    ],
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

function figures(known, timing) {
  const names = [
    ["mean", "mean"],
    ["sd", "sd"],
    ["smallest", "min"],
    ["50 %", "p50"],
    ["99 %", "p99"],
    ["99.9 %", "p99_9"],
    ["largest", "max"],
  ];
  const rows = known.map(({ key, title }) => ({
    head: title,
    cells: [...names.map(([, name]) => fixed(timing[key][name], 2)), String(timing[key].n)],
  }));
  return table(
    "In microseconds",
    [{ title: "time", hidden: true }, ...names.map(([title]) => ({ title })), { title: "n" }],
    rows,
  );
}

function counts(object, what) {
  return Object.entries(object ?? {})
    .filter(([, n]) => n > 0)
    .map(([why, n]) => `${what}: ${n} ${why.replaceAll("_", " ")}`);
}
