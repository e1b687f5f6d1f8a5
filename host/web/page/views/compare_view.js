// Two series: their differences with uncertainty, and whether they are decided.
import { getJson, path, withQuery } from "../live/api.js";
import { differenceBar } from "../charts/difference_chart.js";
import { fill, h } from "../parts/dom.js";
import { badge, problem, quiet, viewHeading } from "../parts/notices.js";
import { table } from "../parts/table.js";
import { rounded, significant, unitWords } from "../words/numbers.js";
import { routeTo } from "../words/routes.js";
import { condition } from "../words/shots.js";
import { dateAndTime } from "../words/times.js";

export async function compareView(main, { live, route, signal }) {
  const choice = h("form", { class: "compare-choice" });
  const result = h("section", { "aria-label": "Differences" });
  fill(main, viewHeading("Compare two series"), choice, result);
  try {
    const sessions = await getJson(path("sessions"), signal);
    showChoice(choice, sessions, route.query);
    const { first, second } = route.query;
    if (first && second) await compare(result, live.quantities, first, second, signal);
    else
      fill(
        result,
        quiet("Choose two sessions. What both share, as a calibration, cancels as far as it does."),
      );
  } catch (error) {
    if (error.name !== "AbortError") fill(result, problem(`Comparison: ${error.message}.`));
  }
}

function showChoice(form, sessions, { first, second }) {
  const select = (name, chosen) => {
    const words = (s) =>
      [s.id, condition(s), dateAndTime(s.utc), `${s.counted} counted`].filter(Boolean).join(", ");
    const element = h(
      "select",
      { name },
      sessions.map((s) => h("option", { value: s.id }, words(s))),
    );
    if (chosen) element.value = chosen;
    return element;
  };
  const one = select("first", first ?? sessions[0]?.id);
  const other = select("second", second ?? sessions.find((s) => s.id !== one.value)?.id);
  fill(
    form,
    h("label", { class: "choice" }, h("span", {}, "First"), one),
    h("label", { class: "choice" }, h("span", {}, "less second"), other),
    h("button", { type: "submit" }, "Compare"),
  );
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    location.hash = routeTo("compare", [], { first: one.value, second: other.value });
  });
}

async function compare(place, quantities, first, second, signal) {
  fill(place, quiet("Comparing."));
  const answer = await getJson(withQuery(path("compare"), { first, second }), signal);
  const known = quantities.filter((q) => answer.quantities[q.name]);
  if (known.length === 0) return fill(place, quiet("Two counted shots of each are needed."));
  const [one, other] = answer.compare ?? [first, second];
  return fill(
    place,
    differencesTable(known, answer, one, other),
    quiet(
      "Bars: the 95 % interval in units of its own half width, zero in the middle. Where a bar does not hold zero, the series differ.",
    ),
  );
}

function differencesTable(known, answer, one, other) {
  const rows = known.map((q) => {
    const d = answer.quantities[q.name];
    const cell = (number) => rounded(number, d.total_sd);
    return {
      head: q.label,
      cells: [
        unitWords(q.unit),
        cell(d.difference),
        cell(d.expanded_uncertainty),
        differenceBar(d.difference, d.expanded_uncertainty),
        d.decided ? badge("plain", "differs") : "not decided",
        cell(d.total_sd),
        cell(d.standard_error),
        cell(d.shared_sd),
        significant(d.p_value),
        furtherShots(d),
      ],
    };
  });
  return table(
    `${one} less ${other}`,
    [
      { title: "quantity", hidden: true },
      { title: "unit", hidden: true, words: true },
      { title: "difference" },
      { title: "± 95 %" },
      { title: "difference in its ± 95 %", words: true },
      { title: "decided", hidden: true, words: true },
      { title: "total sd" },
      { title: "std error" },
      { title: "shared" },
      { title: "p" },
      { title: "further shots", words: true },
    ],
    rows,
  );
}

function furtherShots({ more_shots: [first, second] = [null, null], difference_asked: asked }) {
  if (first === null) return asked > 0 ? "no number would do" : "–";
  return first === 0 && second === 0 ? "enough" : `${first} + ${second}`;
}
