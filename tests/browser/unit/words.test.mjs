import assert from "node:assert/strict";
import { test } from "node:test";
import { recordWords, stepNumber, stepState } from "../../../host/web/page/words/commissioning.js";
import { parseRoute, routeTo } from "../../../host/web/page/words/routes.js";
import { announcement, condition, remarks, verdict } from "../../../host/web/page/words/shots.js";
import { dateAndTime, duration } from "../../../host/web/page/words/times.js";
import { clockWords, spread } from "../../../host/web/page/words/timing.js";

test("a route is read back as it was written, whatever is in its names", () => {
  for (const name of ["2026-11-23", "a/b", "50 %", "<b>ü</b>", "#?&=+"]) {
    const { view, parts, query } = parseRoute(routeTo("shot", [name, "3"], { spin: name, angle: null }));
    assert.deepEqual({ view, parts, query }, { view: "shot", parts: [name, "3"], query: { spin: name } });
  }
});

test("an unknown or damaged address opens the first view", () => {
  for (const hash of ["", "#", "#/", "#/nowhere/1"])
    assert.deepEqual(parseRoute(hash), { view: "shot", parts: [], query: {} });
  assert.deepEqual(parseRoute("#/history/%zz").parts, ["%zz"]);
});

test("a rejected shot tells why", () => {
  assert.deepEqual(verdict({ counted: false, rejected: "too few images" }), {
    text: "rejected",
    level: "caution",
    reason: "too few images",
  });
  assert.equal(verdict({ counted: true, rejected: null }).text, "counted");
  assert.equal(verdict({ counted: false, rejected: null, dry: true }).text, "dry");
});

test("remarks are the reason, and flags that it does not name already", () => {
  const flags = ["too_few_images", "no_redundancy"];
  assert.equal(
    remarks({ counted: false, rejected: "too few images of the ball", flags }),
    "too few images of the ball; no redundancy",
  );
  assert.equal(remarks({ counted: true, rejected: null, flags }), "too few images, no redundancy");
  assert.equal(remarks({ counted: true, rejected: null, flags: [] }), "");
});

test("a new shot is announced in one sentence", () => {
  const quantities = [
    { name: "e", label: "restitution e", unit: "" },
    { name: "omega_lo_radps", label: "spin lift-off", unit: "rad/s" },
  ];
  const values = { e: { value: 0.876, sd: 0.0026 }, omega_lo_radps: { value: null, sd: null } };
  assert.equal(
    announcement({ name: "7", counted: true, values }, quantities),
    "Shot 7 counted. restitution e 0.8760 ± 0.0026.",
  );
  assert.equal(
    announcement({ name: "8", counted: false, rejected: "no photograph", values: {} }, quantities),
    "Shot 8 rejected: no photograph.",
  );
});

test("a condition is spin and angle, as far as they are known", () => {
  assert.equal(condition({ spin: "top", angle_deg: 34 }), "top 34°");
  assert.equal(condition({ spin: null, angle_deg: null }), "");
});

test("times are told in UTC, ages in the largest unit that fits", () => {
  assert.equal(dateAndTime("2026-11-23T14:02:11.123Z"), "2026-11-23 14:02:11");
  assert.deepEqual([12, 180, 7200, 864000].map(duration), ["12 s", "3 min", "2 h", "10 days"]);
});

test("a histogram is told in one sentence", () => {
  assert.equal(
    spread({ p50: 0.02, p99: 0.06, p99_9: 1.5, max: 12.31, n: 1234 }),
    "Half were below 0.02 µs, 99 of 100 below 0.06 µs, 999 of 1000 below 1.50 µs; the largest was 12.3 µs, of 1234 measured.",
  );
});

test("a clock that no clock could be is said to be suspect", () => {
  const clock = {
    drift_ppm: 900.123,
    drift_sd_ppm: 0.11,
    offset_sd_s: 3.8e-6,
    latency_s: null,
    suspect: true,
  };
  assert.equal(
    clockWords(clock),
    "The firmware's clock drifts by 900.12 ± 0.11 ppm; its offset is known to ± 3.80 µs. SUSPECT: no clock drifts like this.",
  );
});

const step = (state) => ({ id: state, title: state, state, value: null, unit: "" });

test("a missing, an old, an unfinished and a good record of commissioning are told apart", () => {
  assert.match(recordWords(null).text, /no record/);
  const record = {
    running: false,
    utc: "2026-11-01T10:00:00Z",
    operator: "AB",
    age_days: 3,
    steps: [step("passed")],
  };
  assert.deepEqual(recordWords(record), {
    level: "good",
    text: "Commissioned 2026-11-01 10:00:00 UTC by AB, 3 days old: 1 of 1 steps passed.",
  });
  assert.match(recordWords({ ...record, age_days: 200 }).text, /The record is old/);
  assert.match(
    recordWords({ ...record, steps: [step("passed"), step("failed")] }).text,
    /1 of 2 steps passed\. Not all is proved/,
  );
  assert.match(recordWords({ ...record, running: true, age_days: 200 }).text, /^Under way/);
});

test("a step tells its number with its unit, and its state in words", () => {
  assert.equal(stepNumber({ value: 31.53, unit: "µs" }), "31.5 µs");
  assert.equal(stepNumber({ value: null, unit: "µs" }), "–");
  assert.equal(stepState(step("failed")).text, "FAILED");
});
