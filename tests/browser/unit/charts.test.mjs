import assert from "node:assert/strict";
import { test } from "node:test";
import { barHeights } from "../../../host/web/page/views/timing_view.js";
import {
  labelled, linear, nearestPoint, rangeOf, roundTicks, runChart,
} from "../../../host/web/page/charts/run_chart_model.js";

test("ticks are round numbers within the range, at least two", () => {
  for (const [low, high] of [
    [0, 1],
    [-23.5, -22.1],
    [1e-6, 3e-6],
    [0, 317],
    [-0.003, 0.9],
    [99.999, 100.001],
  ]) {
    const { ticks, decimals } = roundTicks(low, high, 4);
    assert.ok(ticks.length >= 2 && ticks.length <= 5, `${low} to ${high}: ${ticks}`);
    for (const tick of ticks) {
      assert.ok(tick >= low - 1e-9 * Math.abs(low) && tick <= high + 1e-9 * Math.abs(high));
      assert.ok(
        Math.abs(Number(tick.toFixed(decimals)) - tick) < 1e-9 * (high - low),
        `${tick} has more than ${decimals} decimals`,
      );
    }
  }
});

test("a range has room about its values, also about a single one and without any", () => {
  assert.deepEqual(rangeOf([]), [0, 1]);
  for (const values of [[5], [0], [-3, -3], [1, 2]]) {
    const [low, high] = rangeOf([...values, NaN]);
    assert.ok(low < Math.min(...values) && high > Math.max(...values));
  }
});

test("a place on the line is linear", () => {
  const x = linear([0, 10], [100, 200]);
  assert.deepEqual([x(0), x(5), x(10)], [100, 150, 200]);
});

const series = (thesis) => ({
  summary: { quantities: { e: { n: 2, mean: 0.86 } } },
  limits: { e: { mean: 0.86, lower: 0.8, upper: 0.92 } },
  thesis,
  points: [
    { name: "1", counted: true, rejected: null, values: { e: { value: 0.85, sd: 0.01 } } },
    { name: "2", counted: false, rejected: "no photograph", values: { e: { value: null, sd: null } } },
    { name: "3", counted: true, rejected: null, values: {} },
  ],
});

test("a run chart holds every shot, also those without a number", () => {
  const { points, mean, lower, upper, range } = runChart(series(null), "e");
  assert.deepEqual(
    points.map((p) => [p.index, p.name, p.value]),
    [
      [0, "1", 0.85],
      [1, "2", null],
      [2, "3", null],
    ],
  );
  assert.deepEqual([mean, lower, upper], [0.86, 0.8, 0.92]);
  assert.ok(range[0] < 0.8 && range[1] > 0.92);
});

test("the thesis's row widens the chart, unless it would squeeze the shots", () => {
  const near = runChart(series({ e: { value: 0.95, sd: 0.02 } }), "e");
  assert.ok(near.thesis.isShown && near.range[1] > 0.97);
  const far = runChart(series({ e: { value: 9, sd: 0.02 } }), "e");
  assert.ok(!far.thesis.isShown && far.thesis.isAbove && far.range[1] < 1);
});

test("a series without a shot is an empty chart", () => {
  const { points, mean, thesis } = runChart(
    { summary: { quantities: {} }, points: [], limits: {}, thesis: null },
    "e",
  );
  assert.deepEqual([points.length, mean, thesis], [0, null, null]);
  assert.equal(nearestPoint(points, 3), null);
});

test("the nearest point is one of them wherever the pointer is", () => {
  const { points } = runChart(series(null), "e");
  assert.deepEqual(
    [-5, 0.4, 0.6, 99].map((at) => nearestPoint(points, at).name),
    ["1", "1", "2", "3"],
  );
});

test("a single count among ten thousand is seen in a histogram", () => {
  const [many, one, none] = barHeights([10000, 1, 0]);
  assert.equal(many, 1);
  assert.ok(one >= 0.1 && none === 0);
});

const named = (names) => names.map((name, index) => ({ index, name }));

test("shots with round numbers are labelled, few enough to be read", () => {
  const thousand = labelled(named(Array.from({ length: 1000 }, (_, i) => `${i + 1}`)), 6);
  assert.deepEqual(
    thousand.map((p) => p.name),
    ["200", "400", "600", "800", "1000"],
  );
  const later = labelled(named(Array.from({ length: 50 }, (_, i) => `${i + 44}`)), 6);
  assert.deepEqual(
    later.map((p) => p.name),
    ["50", "60", "70", "80", "90"],
  );
  assert.deepEqual(
    labelled(named(["1", "2", "3"]), 6).map((p) => p.name),
    ["1", "2", "3"],
  );
});

test("shots whose names are no ascending numbers are labelled by their place", () => {
  const names = ["1/ab", "2/ab", "1/cd", "2/cd", "3/cd", "4/cd"];
  assert.deepEqual(
    labelled(named(names), 3).map((p) => p.name),
    ["2/ab", "2/cd", "4/cd"],
  );
});
