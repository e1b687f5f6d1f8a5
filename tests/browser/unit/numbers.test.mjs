import assert from "node:assert/strict";
import { test } from "node:test";
import {
  count, decimalsFor, fixed, inWords, microseconds, rounded, signed, significant, valueAndSd,
} from "../../../host/web/page/words/numbers.js";

test("a value has two digits of its standard uncertainty", () => {
  assert.equal(rounded(15.3712, 0.19), "15.37");
  assert.equal(rounded(0.87604, 0.0026), "0.8760");
  assert.equal(rounded(-316.834, 0.28), "−316.83");
  assert.equal(rounded(-316.834, 12.3), "−317");
});

test("decimals go from none to six", () => {
  assert.equal(decimalsFor(1e-9), 6);
  assert.equal(decimalsFor(12345), 0);
  assert.equal(decimalsFor(0.1), 2);
  assert.equal(decimalsFor(0.0999), 3);
  assert.equal(decimalsFor(9.99), 1);
  assert.equal(decimalsFor(0.0036, 1), 3);
  assert.equal(decimalsFor(0.25, 1), 1);
  assert.equal(decimalsFor(12, 1), 0);
});

test("without an uncertainty there are three decimals", () => {
  assert.equal(rounded(1.23456, null), "1.235");
  assert.equal(rounded(1.23456, 0), "1.235");
  assert.equal(rounded(1.23456, NaN), "1.235");
});

test("what is not known is a dash, never a number", () => {
  assert.equal(rounded(null, 0.1), "–");
  assert.equal(rounded(undefined, 0.1), "–");
  assert.equal(fixed(Infinity, 2), "–");
  assert.deepEqual(valueAndSd(undefined), { value: "–", sd: "" });
  assert.deepEqual(valueAndSd({ value: null, sd: null }), { value: "–", sd: "" });
  assert.equal(inWords({ value: null, sd: null }, "m/s"), "–");
});

test("a rounded zero has no sign", () => {
  assert.equal(fixed(-0.001, 2), "0.00");
  assert.equal(signed(0.001, 1), "+0.0");
  assert.equal(signed(-1.26, 1), "−1.3");
});

test("value and sd have as many decimals as each other", () => {
  assert.deepEqual(valueAndSd({ value: 5.3703, sd: 0.0531 }), { value: "5.370", sd: "0.053" });
  assert.equal(inWords({ value: 5.3703, sd: 0.0531 }, "ms"), "5.370 ± 0.053 ms");
  assert.equal(inWords({ value: -23.5, sd: null }, "deg"), "−23.500 °");
});

test("significant digits are counted from the first that is not zero", () => {
  assert.equal(significant(0.04321), "0.043");
  assert.equal(significant(1234, 3), "1234");
  assert.equal(significant(0.5), "0.5");
  assert.equal(significant(100), "100");
  assert.equal(significant(-2.5e-7), "−2.5e−7");
  assert.equal(significant(0), "0");
});

test("microseconds become milliseconds where they are many", () => {
  assert.equal(microseconds(0.024), "0.02 µs");
  assert.equal(microseconds(12.34), "12.3 µs");
  assert.equal(microseconds(1250), "1.25 ms");
});

test("one shot, two shots", () => {
  assert.equal(count(1, "shot"), "1 shot");
  assert.equal(count(0, "shot"), "0 shots");
});
