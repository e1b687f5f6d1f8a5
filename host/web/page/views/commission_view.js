// The rig proved step by step: the run under way, or the newest record.
import { getJson, path } from "../live/api.js";
import { fill, h } from "../parts/dom.js";
import { badge, problem, quiet, viewHeading } from "../parts/notices.js";
import { recordWords, stepNumber, stepState } from "../words/commissioning.js";

export function commissionView(main, { live, signal }) {
  const summary = h("p", { class: "record" });
  const steps = h("ol", { class: "steps" });
  fill(main, viewHeading("Commission"), summary, steps);
  const show = (record) => {
    const { level, text } = recordWords(record);
    fill(
      summary,
      badge(level, level === "good" ? "proved" : level === "plain" ? "running" : "attention"),
      ` ${text}`,
    );
    fill(steps, (record?.steps ?? []).map(stepItem));
  };
  const load = async () => {
    try {
      show(await getJson(path("commission"), signal));
    } catch (error) {
      if (error.name !== "AbortError") fill(summary, problem(`Commissioning: ${error.message}.`));
    }
  };
  fill(summary, quiet("Asking the host."));
  for (const kind of ["commission", "live"]) live.addEventListener(kind, load, { signal });
  load();
}

function stepItem(step) {
  const { text, level } = stepState(step);
  return h(
    "li",
    {
      class: `step ${step.state}`,
      "aria-current": ["running", "waiting"].includes(step.state) ? "step" : null,
    },
    h("div", { class: "step-head" }, h("h2", {}, step.title), badge(level, text)),
    h(
      "p",
      { class: "step-number" },
      h("strong", {}, stepNumber(step)),
      step.limit ? h("span", { class: "quiet" }, ` limit: ${step.limit}`) : null,
    ),
    step.words && h("p", {}, step.words),
    step.advice && h("p", { class: "advice" }, h("strong", {}, "What to do: "), step.advice),
  );
}
