import assert from "node:assert/strict";
import { test } from "node:test";
import { cautions, disconnected, facts, missing, progress } from "../../../host/web/page/words/rig.js";

const good = {
  state: "idle",
  age_s: 0.1,
  key: "on",
  estop: "released",
  danger: "",
  missing: "",
  shots: 7,
  counted: 6,
  wanted: 20,
  armed_by: "",
  real_time: true,
  journal_ok: true,
  events_missing: 0,
  verified: true,
  unverified: { forged: 0 },
  photographs_pending: 0,
};
const told = (status) => facts(status).map(({ name, text }) => `${name} ${text}`);

test("a good rig has its facts and nothing to caution of", () => {
  assert.deepEqual(told(good), ["firmware idle", "key on", "e-stop released"]);
  assert.deepEqual(cautions(good), []);
  assert.equal(missing(good), "");
});

test("who armed it is told", () => {
  assert.ok(told({ ...good, state: "armed", armed_by: "AB" }).includes("armed by AB"));
});

test("a silent firmware's key and e-stop are told in the past tense", () => {
  assert.deepEqual(told({ ...good, state: "silent", age_s: 42 }), [
    "firmware silent for 42 s",
    "key was on",
    "e-stop was released",
  ]);
  assert.equal(missing({ ...good, state: "silent", age_s: 42 }), "the firmware has been silent for 42 s");
});

test("of a firmware that was never heard neither key nor e-stop is told", () => {
  assert.deepEqual(told({ ...good, state: "never_heard", key: "unknown", estop: "unknown" }), [
    "firmware not heard",
  ]);
  assert.equal(missing({ ...good, state: "never_heard" }), "no firmware heard");
  assert.deepEqual(cautions({ ...good, state: "never_heard", real_time: false, journal_ok: false }), []);
});

test("what is not known is said to be unknown", () => {
  assert.deepEqual(told({ ...good, state: "?", key: "unknown", estop: "unknown" }), [
    "firmware unknown",
    "key unknown",
    "e-stop unknown",
  ]);
});

test("a fault is a danger, a pressed e-stop a caution", () => {
  const levels = Object.fromEntries(
    facts({ ...good, state: "fault", estop: "pressed" }).map((f) => [f.name, f.level]),
  );
  assert.deepEqual([levels.firmware, levels["e-stop"]], ["danger", "caution"]);
});

test("each thing that is not as it should be is one line", () => {
  const words = cautions({
    ...good,
    verified: false,
    unverified: { forged: 2, too_old: 0 },
    journal_ok: false,
    real_time: false,
    events_missing: 1,
    photographs_pending: 2,
  });
  assert.deepEqual(words.slice(1), [
    "packets ignored: 2 forged",
    "the firmware's journal cannot be written",
    "the firmware does not run in real time",
    "1 event of the firmware did not arrive here",
    "2 photographs on the way",
  ]);
  assert.match(words[0], /UNVERIFIED/);
});

test("progress counts what is wanted where that is known", () => {
  assert.equal(progress(good), "6 of 20 counted, 7 shots heard");
  assert.equal(progress({ ...good, shots: 1, counted: 1, wanted: null }), "1 shot heard");
});

test("what is told as a danger is not told again as what is missing", () => {
  const danger = "THE OUTPUTS MAY BE ACTIVE: press the e-stop";
  assert.equal(missing({ ...good, danger, missing: danger }), "");
  assert.equal(missing({ ...good, danger, missing: "the key is off" }), "the key is off");
});

test("a page that lost its host says since when", () => {
  const since = new Date("2026-11-23T15:02:11Z");
  assert.match(disconnected({ connected: false, since }), /since 15:02:11 UTC: numbers may be old/);
  assert.match(disconnected({ connected: false, since, ended: true }), /^strobe ended at 15:02:11 UTC/);
  assert.equal(disconnected({ connected: true, since: null }), "");
});
