// The rig proved step by step: the run under way, or its record. Viewers may confirm what only watches inputs; whatever makes
// outputs move, and what somebody saw or heard of it, is answered at the console.
import { getJson, path, postJson } from "../live/api.js";
import { attempt, badge, fill, h, quiet, setText, showIfNew, viewHeading } from "../parts/dom.js";
import { recordWords, stepDoubts, stepNumber, stepState } from "../words/rig.js";

export function commissionView(main, { live, signal }) {
  const summary = h("p", { class: "record" });
  const asked = h("section", { class: "prompt", "aria-label": "What is asked", role: "status" });
  const steps = h("ol", { class: "steps" });
  fill(main, viewHeading("Commission"), summary, asked, steps);
  const show = (record) => {
    const { level, title, text } = recordWords(record);
    fill(summary, badge(level, title), ` ${text}`);
    const { prompt, waiting, steps: all } = record;
    showIfNew(asked, [prompt, waiting, all.map(({ state }) => state)], () => promptContent(record));
    fill(steps, record.steps.map(stepItem));
  };
  const load = () =>
    attempt(summary, "Commissioning", async () => show(await getJson(path("commission"), signal)));
  fill(summary, quiet("Asking the host."));
  live.addEventListener("commission", ({ detail }) => (detail.steps ? show(detail) : load()), { signal });
  live.addEventListener("live", load, { signal });
  load();
}

function promptContent({ prompt, waiting, steps }) {
  const step = steps.find(({ state }) => state === "running" || state === "waiting");
  const heading = (what) => h("h2", {}, step ? `${what}: ${step.title}` : what);
  const answer = h("p", { class: "answer" });
  const send = (what, body, done) => () =>
    postJson(path("commission", what), body).then(
      () => setText(answer, done),
      (error) => setText(answer, `Not done: ${error.message}.`),
    );
  const button = (words, action) => h("button", { type: "button", onclick: action }, words);
  if (prompt) {
    const why = prompt.moves ? "it makes outputs move." : "only who stands at the rig can tell.";
    const console = h("p", {}, h("strong", {}, "Answer at the console: "), why);
    return [
      heading("Asked"),
      h("p", {}, prompt.words),
      prompt.at_console ? console : button("Confirm", send("confirm", { step: prompt.step }, "Confirmed.")),
      answer,
    ];
  }
  if (!waiting) return null;
  return [
    heading("Under way"),
    h("p", {}, waiting),
    button("More time", send("more_time", {}, "There is more time now.")),
    answer,
  ];
}

function stepItem(step) {
  const { text, level } = stepState(step);
  const number = stepNumber(step);
  const doubts = stepDoubts(step);
  return h(
    "li",
    {
      class: `step ${step.state}`,
      "aria-current": ["running", "waiting"].includes(step.state) ? "step" : null,
    },
    h("div", { class: "step-head" }, h("h2", {}, step.title), badge(level, text)),
    (number || step.limit) &&
      h(
        "p",
        {},
        number && h("strong", {}, number),
        step.limit && h("span", { class: "quiet" }, ` limit: ${step.limit}`),
      ),
    doubts && h("p", { class: "doubts" }, doubts),
    step.words && h("p", {}, step.words),
    step.advice && h("p", { class: "advice" }, h("strong", {}, "What to do: "), step.advice),
  );
}
