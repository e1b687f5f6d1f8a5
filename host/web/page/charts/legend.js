// What the marks of a run chart mean.
import { h, svg } from "../parts/dom.js";

const MARKS = [
  [
    "counted shot ± its total sd",
    () => [svg("path", { class: "bars", d: "M12 2V18" }), svg("path", { class: "dots", d: "M12 10h0" })],
  ],
  ["rejected", () => svg("path", { class: "crosses", d: "M8 6l8 8m0 -8l-8 8" })],
  ["mean", () => svg("path", { class: "mean", d: "M1 10H23" })],
  [
    "limits of single shots (3 sd, from their moving range)",
    () => svg("path", { class: "limit", d: "M1 10H23" }),
  ],
  [
    "thesis ± sd",
    () => [
      svg("rect", { class: "thesis-band", x: 1, y: 4, width: 22, height: 12 }),
      svg("path", { class: "thesis-line", d: "M1 10H23" }),
    ],
  ],
];

export function legend() {
  const items = MARKS.map(([words, marks]) =>
    h(
      "li",
      {},
      svg("svg", { viewBox: "0 0 24 20", width: 24, height: 20, "aria-hidden": "true" }, marks()),
      words,
    ),
  );
  return h("ul", { class: "legend", "aria-label": "Marks" }, items);
}
