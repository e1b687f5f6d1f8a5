// The record of commissioning in words. Pure.
import { ABSENT, significant, unitWords } from "./numbers.js";
import { ageWords } from "./timing.js";
import { dateAndTime } from "./times.js";

export const OLD_AFTER_DAYS = 90;

const STATES = {
  pending: { text: "to come", level: "plain" },
  running: { text: "under way", level: "plain" },
  waiting: { text: "waits for you", level: "caution" },
  passed: { text: "passed", level: "good" },
  failed: { text: "FAILED", level: "danger" },
  skipped: { text: "skipped", level: "caution" },
};

export function stepState(step) {
  return STATES[step.state] ?? { text: step.state, level: "plain" };
}

/// "0.42 µs"
export function stepNumber({ value, unit }) {
  return Number.isFinite(value) ? [significant(value, 3), unitWords(unit)].filter(Boolean).join(" ") : ABSENT;
}

/// {level, text}: what the record as a whole says; `record` null: there is none.
export function recordWords(record) {
  if (!record || !record.steps?.length)
    return { level: "caution", text: "This rig has no record of commissioning. Run strobe commission." };
  const left = record.steps.filter((s) => s.state !== "passed");
  const of = `${record.steps.length - left.length} of ${record.steps.length} steps passed`;
  if (record.running) return { level: "plain", text: `Under way: ${of}.` };
  const who = record.operator ? ` by ${record.operator}` : "";
  const dated = `Commissioned ${dateAndTime(record.utc)} UTC${who}, ${ageWords(record.age_days)}: ${of}.`;
  if (record.age_days > OLD_AFTER_DAYS)
    return { level: "caution", text: `${dated} The record is old: commission again.` };
  if (left.length > 0) return { level: "caution", text: `${dated} Not all is proved.` };
  return { level: "good", text: dated };
}
