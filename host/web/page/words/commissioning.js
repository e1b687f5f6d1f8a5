// Commissioning in words: the record of a rig, or the run under way. Pure.
import { ABSENT, significant, unitWords, valueAndSd } from "./numbers.js";
import { ageWords } from "./timing.js";
import { dateAndTime } from "./times.js";

const STATES = {
  pending: { text: "to come", level: "plain" },
  running: { text: "under way", level: "plain" },
  waiting: { text: "waits for you", level: "caution" },
  passed: { text: "passed", level: "good" },
  failed: { text: "FAILED", level: "danger" },
  skipped: { text: "left out", level: "caution" },
};

export function stepState(step) {
  return STATES[step.state] ?? { text: step.state, level: "plain" };
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

function limit({ max_age_days: days }) {
  return days > 0 ? `, at most ${days} days are allowed` : "";
}

function sentence(words) {
  return words === ABSENT ? words : `${words[0].toUpperCase()}${words.slice(1)}.`;
}
