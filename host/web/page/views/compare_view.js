// Two series: their differences with uncertainty, and whether they are decided.
import { getJson, path } from "../live/api.js";
import { attempt, badge, choice, fill, h, quiet, viewHeading } from "../parts/dom.js";
import { QUANTITY, table, UNIT } from "../parts/table.js";
import { dateAndTime, rounded, significant, unitWords } from "../words/numbers.js";
import { routeTo, withQuery } from "../words/routes.js";
import { condition, keyWords } from "../words/shots.js";

export function compareView(main, { live, route, signal }) {
  const form = h("form", { class: "compare-choice" });
  const result = h("section", { "aria-label": "Differences" });
  fill(main, viewHeading("Compare two series"), form, result);
  return attempt(result, "Comparison", async () => {
    const sessions = await getJson(path("sessions"), signal);
    if (sessions.length === 0) return fill(result, quiet("No session yet."));
    showChoice(form, sessions, route.query);
    const { first, second } = route.query;
    if (first && second) return compare(result, live.quantities, route.query, signal);
    return fill(
      result,
      quiet("Choose two sessions. What both share, as a calibration, cancels as far as it does."),
    );
  });
}

function showChoice(form, sessions, { first, second }) {
  const words = (s) =>
    [s.id, condition(s), dateAndTime(s.utc), `${s.counted} counted`].filter(Boolean).join(", ");
  const options = sessions.map((s) => [s.id, words(s)]);
  const one = choice("First", options, first ?? sessions[0]?.id, null, { name: "first" });
  const other = sessions.find((s) => s.id !== one.select.value)?.id;
  const two = choice("less second", options, second ?? other, null, { name: "second" });
  fill(form, one.element, two.element, h("button", { type: "submit" }, "Compare"));
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    location.hash = routeTo("compare", [], { first: one.select.value, second: two.select.value });
  });
}

async function compare(place, quantities, query, signal) {
  fill(place, quiet("Comparing."));
  const answer = await getJson(withQuery(path("compare"), query), signal);
  if (!answer.quantities) return fill(place, conditionChoices(answer, query));
  const known = quantities.filter((q) => answer.quantities[q.name]);
  if (known.length === 0) return fill(place, quiet("Two counted shots of each are needed."));
  const named = ({ name }) => name && ` (${name})`;
  const [one, other] = answer.compare.map((session, i) => session + answer.conditions[i].map(named).join());
  const { differ } = answer;
  return fill(
    place,
    differ.length > 0 && h("p", {}, `The two differ in ${keyWords(differ)}.`),
    differencesTable(known, answer, one, other),
    quiet("Where the 95 % interval does not hold zero, the series differ."),
  );
}

/// Of a session whose shots differ one condition is compared.
function conditionChoices({ conditions, differ }, query) {
  const chosen = ["first", "second"].map((side, i) => {
    if (conditions[i].length < 2) return null;
    const options = conditions[i].map(({ name, counted, like }) => [like, `${name}, ${counted} counted`]);
    const open = (like) => (location.hash = routeTo("compare", [], { ...query, [`${side}_like`]: like }));
    return choice(`Which shots of ${query[side]}`, [["", "choose"], ...options], "", open).element;
  });
  return [h("p", {}, `The shots differ in ${keyWords(differ)}: no mean over them is made.`), chosen];
}

function differencesTable(known, answer, one, other) {
  const rows = known.map((q) => {
    const d = answer.quantities[q.name];
    const cell = (number) => rounded(number, d.total_sd);
    return {
      head: q.label,
      cells: [
        unitWords(q.unit),
        ...[d.difference, d.expanded_uncertainty].map(cell),
        d.decided ? badge("plain", "differs") : "not decided",
        ...[d.total_sd, d.standard_error, d.shared_sd].map(cell),
        significant(d.p_value),
        furtherShots(d),
      ],
    };
  });
  return table(
    `${one} less ${other}`,
    [
      QUANTITY,
      UNIT,
      "difference",
      "± 95 %",
      { title: "decided", hidden: true, words: true },
      ...["total sd", "std error", "shared", "p"],
      { title: "further shots", words: true },
    ],
    rows,
  );
}

function furtherShots({ more_shots: [first, second] = [null, null], difference_asked: asked }) {
  if (first === null) return asked > 0 ? "no number would do" : "–";
  if (Math.max(first, second) > 10_000) return "more than 10,000";
  return first === 0 && second === 0 ? "enough" : `${first} + ${second}`;
}
