// A histogram of times in microseconds. Heights are logarithmic: the single late flash among ten thousand must be seen.
import { svg } from "../parts/dom.js";
import { fixed } from "../words/numbers.js";
import { roundTicks } from "./scale.js";

const WIDTH = 420,
  HEIGHT = 130,
  BOTTOM = 20,
  SIDE = 14;

/// Heights between 0 and 1: log(n) over the largest's, at least a sliver for a single one.
export function barHeights(bins) {
  const most = Math.max(...bins, 1);
  return bins.map((n) => (n <= 0 ? 0 : most === 1 ? 1 : 0.1 + (0.9 * Math.log(n)) / Math.log(most)));
}

export function histogram({ bin_first: first, bin_width: width, bins }) {
  if (!bins?.length || !(width > 0)) return null;
  const last = first + width * bins.length;
  const x = (value) => SIDE + ((value - first) / (last - first)) * (WIDTH - 2 * SIDE);
  const floor = HEIGHT - BOTTOM;
  const bars = barHeights(bins).map(
    (height, i) =>
      height > 0 &&
      svg("rect", {
        class: "bar-of-counts",
        x: x(first + i * width) + 0.5,
        y: floor - height * (floor - 6),
        height: height * (floor - 6),
        width: Math.max(1, x(first + (i + 1) * width) - x(first + i * width) - 1),
      }),
  );
  const { ticks, decimals } = roundTicks(first, last, 5);
  const labels = ticks.map((tick) =>
    svg("text", { x: x(tick), y: HEIGHT - 5, "text-anchor": "middle" }, fixed(tick, decimals)),
  );
  return svg(
    "svg",
    { class: "histogram", viewBox: `0 0 ${WIDTH} ${HEIGHT}`, "aria-hidden": "true" },
    svg("path", { class: "axis", d: `M${SIDE} ${floor}H${WIDTH - SIDE}` }),
    bars,
    labels,
  );
}
