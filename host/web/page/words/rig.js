// The rig in words: what its bar says, from a STATUS; its timing; how it was commissioned. Pure.
import {
  count, dateAndTime, duration, fixed, microseconds, significant, unitWords, valueAndSd,
} from "./numbers.js";

/// What each is called, and how far it is from how one wants it.
const STATES = {
  never_heard: ["not heard", "caution"],
  silent: ["silent", "caution"],
  idle: ["idle", "plain"],
  armed: ["ARMED", "caution"],
  firing: ["FIRING", "caution"],
  spent: ["arming spent, arm again", "plain"],
  stopped: ["STOPPED", "caution"],
  fault: ["FAULT", "danger"],
};
const KEY = { on: ["on", "caution"], off: ["OFF", "plain"] };
const ESTOP = { released: ["released", "plain"], pressed: ["PRESSED", "caution"] };
const UNKNOWN = ["unknown", "caution"];

/// [{name, text, level}], level "plain", "caution" or "danger". What an old status says is told in the past tense.
export function facts(status) {
  if (!status) return [];
  const [words, level] = STATES[status.state] ?? UNKNOWN;
  const silent = status.state === "silent";
  const all = [{ name: "firmware", text: silent ? `silent for ${duration(status.age_s)}` : words, level }];
  if (status.state !== "never_heard")
    all.push(fact("key", KEY[status.key], silent), fact("e-stop", ESTOP[status.estop], silent));
  if (status.armed_by) all.push({ name: "armed by", text: status.armed_by, level: "plain" });
  return all;
}

function fact(name, known, silent) {
  const [text, level] = known ?? UNKNOWN;
  return silent && known ? { name, text: `was ${text}`, level: "caution" } : { name, text, level };
}

/// "6 of 20 counted, 7 shots heard": a shot's number counts from the firmware's start, and a series that is gone on with counts
/// shots of before.
export function progress(status) {
  if (!status) return "";
  const wanted = Number.isFinite(status.wanted) ? `${status.counted ?? 0} of ${status.wanted} counted, ` : "";
  return `${wanted}${count(status.shots ?? 0, "shot")} heard`;
}

/// Why nothing can be fired, in words, or ""; a danger says so itself.
export function missing(status) {
  if (!status || (status.danger && status.missing === status.danger)) return "";
  if (status.missing) return status.missing;
  if (status.state === "never_heard") return "no firmware heard";
  return status.state === "silent" ? `the firmware has been silent for ${duration(status.age_s)}` : "";
}

/// What is not as it should be, but stops nothing.
export function cautions(status) {
  if (!status) return [];
  const words = [];
  if (status.verified === false)
    words.push("UNVERIFIED: without the lab's key, anybody's messages are shown");
  const ignored = Object.entries(status.unverified ?? {}).filter(([, n]) => n > 0);
  if (ignored.length > 0)
    words.push(
      `packets ignored: ${ignored.map(([why, n]) => `${n} ${why.replaceAll("_", " ")}`).join(", ")}`,
    );
  const heard = status.state !== "never_heard";
  if (heard && status.journal_ok === false) words.push("the firmware's journal cannot be written");
  if (heard && status.real_time === false) words.push("the firmware does not run in real time");
  if (status.events_missing > 0)
    words.push(`${count(status.events_missing, "event")} of the firmware did not arrive here`);
  if (status.photographs_pending > 1)
    words.push(`${count(status.photographs_pending, "photograph")} on the way`);
  return words;
}

/// Whether the page itself hears its host. `connection`: {connected, since: Date | null, ended}.
export function disconnected({ connected, since, ended }) {
  if (connected || !since) return "";
  const at = `${since.toISOString().slice(11, 19)} UTC`;
  if (ended) return `strobe ended at ${at}: what is shown here was so until then.`;
  return `This page has heard nothing from the host since ${at}: numbers may be old.`;
}

const SEEN = "from the call's end to the light that the sensor saw";
/// {key of the histogram, title, words}.
export const TIMINGS = [
  ["lateness_us", "Lateness of a flash's pulse", "from the commanded instant to the call that sets the line"],
  ["issue_us", "Length of the call that sets the lines", "what the kernel takes for one instant"],
  ["skew_us", "Lamp A against lamp B", "light of A less light of B, of flashes that both sensors saw"],
  ["lamp_delay_a_us", "Delay of lamp A", SEEN],
  ["lamp_delay_b_us", "Delay of lamp B", SEEN],
  ["period_error_us", "Error of the intervals between flashes", "as seen by the sensors"],
].map(([key, title, words]) => ({ key, title, words }));

/// "Half were within 0.02 µs, 99 of 100 within 0.06 µs, the largest was 12.3 µs, of 1234."
export function spread(h) {
  return (
    `Half were below ${microseconds(h.p50)}, 99 of 100 below ${microseconds(h.p99)}, 999 of 1000 below ${microseconds(h.p99_9)}; ` +
    `the largest was ${microseconds(h.max)}, of ${h.n} measured.`
  );
}

/// The firmware's clock against this machine's.
export function clockWords(clock) {
  if (!clock) return "";
  const parts = [];
  if (Number.isFinite(clock.drift_ppm)) parts.push(`drifts by ${fixed(clock.drift_ppm, 1)} ppm`);
  if (Number.isFinite(clock.latency_s))
    parts.push(`the last heartbeat came ${fixed(clock.latency_s * 1e3, 2)} ms after the fastest`);
  const words = parts.length
    ? `The firmware's clock ${parts.join("; ")}.`
    : "The firmware's clock is not yet known.";
  return clock.suspect ? `${words} SUSPECT: no clock drifts like this.` : words;
}

export function ageWords(days) {
  if (!Number.isFinite(days)) return "of unknown age";
  return days < 1 ? "less than a day old" : `${count(Math.floor(days), "day")} old`;
}

const STEP_STATES = {
  pending: ["to come", "plain"],
  running: ["under way", "plain"],
  waiting: ["waits for you", "caution"],
  passed: ["passed", "good"],
  failed: ["FAILED", "danger"],
  not_told: ["not told apart from its limit", "caution"],
  skipped: ["left out", "caution"],
};

export function stepState(step) {
  const [text, level] = STEP_STATES[step.state] ?? [step.state, "plain"];
  return { text, level };
}

/// "12.10 ± 0.31 µs", or "" where nothing was measured.
export function stepNumber({ value, sd, unit }) {
  if (!Number.isFinite(value)) return "";
  const number = valueAndSd({ value, sd });
  const words = number.sd ? `${number.value} ± ${number.sd}` : significant(value, 3);
  return [words, unitWords(unit)].filter(Boolean).join(" ");
}

/// Why a result that was good when it was found may not be so any more.
export function stepDoubts({ changed, old, utc }) {
  const since = utc ? `, ${dateAndTime(utc)} UTC` : "";
  if (changed) return `found before the rig file was changed${since}`;
  return old ? `old${since}` : "";
}

/// {level, title, text}: what the record as a whole says.
export function recordWords(record) {
  const passed = record.steps.filter((step) => step.state === "passed").length;
  const of = `${passed} of ${record.steps.length} steps passed`;
  if (record.running) return { level: "plain", title: "under way", text: `${of}.` };
  const standing = sentence(
    record.standing || (record.steps.length > 0 ? of : "the rig has no record of commissioning"),
  );
  const by = record.operator ? `, newest step by ${record.operator}` : "";
  const age = Number.isFinite(record.age_days)
    ? ` The oldest step is ${ageWords(record.age_days)}${limit(record)}${by}.`
    : "";
  return {
    level: record.good ? "good" : "caution",
    title: record.good ? "proved" : "not proved",
    text: standing + age,
  };
}

const limit = ({ max_age_days: days }) => (days > 0 ? `, at most ${days} days are allowed` : "");

const sentence = (words) => `${words[0].toUpperCase()}${words.slice(1)}.`;
