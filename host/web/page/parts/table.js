// Tables: a caption, column headings with units, rows with headings of their own.
import { h } from "./dom.js";

/// Of what most tables begin with.
export const QUANTITY = { title: "quantity", hidden: true };
export const UNIT = { title: "unit", hidden: true, words: true };

/// columns: titles, or {title, unit?, words?: true, hidden?: true}; hidden titles are for listeners only; rows: [{head, cells, class?}],
/// head and cells are text or elements. The table scrolls sideways by itself where the screen is narrow, and can be focused
/// for that.
export function table(caption, titles, rows, { hideCaption = false, className = "" } = {}) {
  const columns = titles.map((column) => (typeof column === "string" ? { title: column } : column));
  const headings = columns.map(({ title, unit, words, hidden }) =>
    h(
      "th",
      { scope: "col", class: words ? "words" : null },
      hidden ? h("span", { class: "visually-hidden" }, title) : title,
      unit ? h("span", { class: "unit" }, ` ${unit}`) : null,
    ),
  );
  const body = rows.map((row) =>
    h(
      "tr",
      { class: row.class ?? null },
      h("th", { scope: "row" }, row.head),
      row.cells.map((cell, i) => h("td", { class: columns[i + 1]?.words ? "words" : null }, cell)),
    ),
  );
  return h(
    "div",
    { class: "table-scroll", tabindex: "0", role: "region", "aria-label": caption },
    h(
      "table",
      { class: className || null },
      h("caption", { class: hideCaption ? "visually-hidden" : null }, h("span", {}, caption)),
      h("thead", {}, h("tr", {}, headings)),
      h("tbody", {}, body),
    ),
  );
}
