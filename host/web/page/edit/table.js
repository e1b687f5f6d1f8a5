// The table of what corrections change, and what is told of a preview that is under way or failed.
import { h } from "../parts/dom.js";
import { comparisonRows } from "./comparison.js";

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
  const rest = h("details", {}, h("summary", {}, "All numbers"), h("div", { class: "edit-wide", tabindex: "0" }, others.element));
  const note = h("p", { class: "edit-note" }, "A change of one sd is as large as the value before was uncertain.");
  const state = h("p", { class: "edit-state", role: "status" });
  const problem = h("p", { class: "edit-problem", role: "alert" });
  const wide = h("div", { class: "edit-wide", tabindex: "0", role: "group", "aria-label": "The readout, before and after" }, essentials.element);
  const element = h("section", { class: "edit-comparison", "aria-label": "What the corrections change" }, state, problem, wide, rest, note);

  function showTables(whether) {
    for (const part of [wide, rest, note]) part.hidden = !whether;
  }
  showTables(false);
  return {
    element,
    show({ before, after, problem: words }, quantities) {
      const rows = comparisonRows(quantities, before, after);
      essentials.body.replaceChildren(...bodyOf(rows.filter((row) => row.essential)));
      others.body.replaceChildren(...bodyOf(rows.filter((row) => !row.essential)));
      problem.textContent = words ?? "";
      showTables(rows.length > 0);
    },
    tell: (words) => { state.textContent = words; },
    fail: (words) => { problem.textContent = words; },
    clear() {
      problem.textContent = "";
      showTables(false);
    },
  };
}
