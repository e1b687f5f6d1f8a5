// The table of what corrections change, and what is told of a preview that is under way or failed.
import { h } from "../parts/dom.js";
import { comparisonRows, verdictWords } from "./comparison.js";

function bodyOf(rows) {
  return rows.map(({ label, before, after, change }) => h("tr", { class: change.endsWith("large") ? "is-large" : null },
    h("th", { scope: "row" }, label), h("td", {}, before), h("td", {}, after), h("td", {}, change)));
}

function emptyTable(caption) {
  const body = h("tbody");
  const heads = ["", "before", "after", "change"].map((text) => (text ? h("th", { scope: "col" }, text) : h("td")));
  return { body, element: h("table", { class: "edit-table" }, h("caption", {}, caption), h("thead", {}, h("tr", {}, ...heads)), body) };
}

export function createTable() {
  const essentials = emptyTable("The readout, before and after");
  const others = emptyTable("Its other numbers");
  const rest = h("details", {}, h("summary", {}, "All numbers"), h("div", { class: "edit-wide", tabindex: "0", role: "group", "aria-label": "All numbers, before and after" }, others.element));
  const note = h("p", { class: "edit-note" }, "A change of one sd is as large as the value before was uncertain.");
  const state = h("p", { class: "edit-state" });
  const verdict = h("p", { class: "edit-verdict" });
  const problem = h("p", { class: "edit-problem", role: "alert" });
  const wide = h("div", { class: "edit-wide", tabindex: "0", role: "group", "aria-label": "The readout, before and after" }, essentials.element);
  const element = h("section", { class: "edit-comparison", "aria-label": "What the corrections change" }, state, problem, verdict, wide, rest, note);

  function showTables(whether) {
    for (const part of [wide, rest, note]) part.hidden = !whether;
  }
  showTables(false);
  return {
    element,
    /// answer: of a preview. Without numbers after the corrections those of the last ones stay, with what is wrong.
    show({ before, after, rejected, problem: words }, quantities) {
      problem.textContent = words ?? "";
      verdict.textContent = after ? verdictWords(rejected) : "";
      if (!after) return;
      const rows = comparisonRows(quantities, before, after);
      essentials.body.replaceChildren(...bodyOf(rows.filter((row) => row.essential)));
      others.body.replaceChildren(...bodyOf(rows.filter((row) => !row.essential)));
      showTables(rows.length > 0);
    },
    tell: (words) => { state.textContent = words; },
    fail: (words) => { problem.textContent = words; },
    clear() {
      problem.textContent = verdict.textContent = "";
      showTables(false);
    },
  };
}
