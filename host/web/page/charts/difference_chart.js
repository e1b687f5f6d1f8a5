// Differences of two series, each in units of its own 95 % uncertainty: whether the bar holds zero is whether it is decided.
import { svg } from "../parts/dom.js";
import { linear } from "./scale.js";

const WIDTH = 300,
  HEIGHT = 24,
  LARGEST = 4;

/// `difference`, `expanded` > 0: in one unit. An inline drawing, told in words by the row that it stands in.
export function differenceBar(difference, expanded) {
  const x = linear([-LARGEST, LARGEST], [8, WIDTH - 8]);
  const inside = (value) => Math.min(LARGEST, Math.max(-LARGEST, value));
  const ratio = difference / expanded;
  const middle = HEIGHT / 2;
  const beyond = Math.abs(ratio) > LARGEST;
  const at = x(inside(ratio));
  const point = beyond
    ? svg("path", {
        class: "beyond",
        d: ratio > 0 ? `M${at - 8} ${middle - 6}l8 6l-8 6z` : `M${at + 8} ${middle - 6}l-8 6l8 6z`,
      })
    : svg("circle", { class: "difference-point", cx: at, cy: middle, r: 4.5 });
  return svg(
    "svg",
    {
      class: "difference",
      viewBox: `0 0 ${WIDTH} ${HEIGHT}`,
      width: WIDTH,
      height: HEIGHT,
      "aria-hidden": "true",
    },
    svg("path", { class: "grid", d: `M8 ${middle}H${WIDTH - 8}` }),
    svg("path", { class: "zero", d: `M${x(0)} 1V${HEIGHT - 1}` }),
    svg("path", { class: "difference-bar", d: `M${x(inside(ratio - 1))} ${middle}H${x(inside(ratio + 1))}` }),
    point,
  );
}
