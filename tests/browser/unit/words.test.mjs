import assert from "node:assert/strict";
import { test } from "node:test";
import {
  clockWords, recordWords, spread, stepDoubts, stepNumber, stepState,
} from "../../../host/web/page/words/rig.js";
import { parseRoute, routeTo } from "../../../host/web/page/words/routes.js";
import { announcement, condition, keyWords, remarks, verdict } from "../../../host/web/page/words/shots.js";
import { dateAndTime, duration } from "../../../host/web/page/words/numbers.js";

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

test("a condition is spin, angle, surface and ball, as far as they are known", () => {
  assert.equal(condition({ spin: "zero", angle_deg: 23, surface: "acrylic", ball: "ITF type 2" }), "zero 23°, acrylic, ITF type 2");
  assert.equal(condition({ angle_deg: 23, surfaces: ["acrylic", "cushion"], balls: [] }), "23°, acrylic / cushion");
  assert.equal(condition({ surface: null, ball: "old" }), "old");
  assert.equal(condition(null), "");
  assert.equal(condition({ spin: "top", angle_deg: 34 }), "top 34°");
  assert.equal(condition({ spin: null, angle_deg: null }), "");
});

test("what shots differ in is told in words", () => {
  assert.equal(keyWords(["surface_name"]), "surface");
  assert.equal(keyWords(["surface_angle_deg", "operator", "temperature_c"]), "surface angle, operator and temperature");
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
    drift_ppm: 1900.123,
    latency_s: null,
    suspect: true,
  };
  assert.equal(
    clockWords(clock),
    "The firmware's clock drifts by 1900.1 ppm. SUSPECT: no clock drifts like this.",
  );
});

const step = (state) => ({ id: state, title: state, state, value: null, sd: null, unit: "" });

test("a missing, a doubtful and a good record of commissioning are told apart", () => {
  const absent = {
    running: false,
    standing: "the rig has not been commissioned: run `strobe commission`",
    good: false,
    age_days: null,
    steps: [],
  };
  assert.deepEqual(recordWords(absent), {
    level: "caution",
    title: "not proved",
    text: "The rig has not been commissioned: run `strobe commission`.",
  });
  const good = {
    running: false,
    standing: "the rig is commissioned on 2026-11-01",
    good: true,
    age_days: 3,
    max_age_days: 90,
    operator: "AB",
    steps: [step("passed")],
  };
  assert.deepEqual(recordWords(good), {
    level: "good",
    title: "proved",
    text: "The rig is commissioned on 2026-11-01. The oldest step is 3 days old, at most 90 days are allowed, newest step by AB.",
  });
  assert.equal(recordWords({ ...good, good: false }).level, "caution");
  assert.match(recordWords({ ...good, age_days: 0 }).text, /less than a day old/);
});

test("a run under way counts its steps", () => {
  const run = {
    running: true,
    standing: "",
    good: false,
    age_days: 0,
    steps: [step("passed"), step("failed"), step("pending")],
  };
  assert.deepEqual(recordWords(run), { level: "plain", title: "under way", text: "1 of 3 steps passed." });
});

test("a step tells its number with uncertainty and unit, and its state in words", () => {
  assert.equal(stepNumber({ value: 31.53, sd: null, unit: "us" }), "31.5 µs");
  assert.equal(stepNumber({ value: 9.8123, sd: 0.021, unit: "m/s2" }), "9.812 ± 0.021 m/s2");
  assert.equal(stepNumber({ value: null, sd: null, unit: "us" }), "");
  assert.equal(stepState(step("failed")).text, "FAILED");
  assert.deepEqual(stepState(step("not_told")), { text: "not told apart from its limit", level: "caution" });
});

test("a result from before the rig file's change, or an old one, is in doubt", () => {
  assert.equal(
    stepDoubts({ changed: true, old: true, utc: "2026-11-01T10:00:00.123Z" }),
    "found before the rig file was changed, 2026-11-01 10:00:00 UTC",
  );
  assert.equal(stepDoubts({ changed: false, old: true, utc: null }), "old");
  assert.equal(stepDoubts({ changed: false, old: false, utc: "2026-11-01T10:00:00Z" }), "");
});
