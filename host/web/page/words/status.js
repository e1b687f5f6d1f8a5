// What the rig's bar says, from a STATUS. Pure.
import { duration } from "./times.js";
import { count } from "./numbers.js";

const STATES = {
  never_heard: { text: "not heard", level: "caution" },
  silent: { text: "silent", level: "caution" },
  idle: { text: "idle", level: "plain" },
  armed: { text: "ARMED", level: "caution" },
  firing: { text: "FIRING", level: "caution" },
  spent: { text: "spent, to be armed anew", level: "plain" },
  stopped: { text: "STOPPED", level: "caution" },
  fault: { text: "FAULT", level: "danger" },
};
const KEY = { on: { text: "on", level: "caution" }, off: { text: "OFF", level: "plain" } };
const ESTOP = {
  released: { text: "released", level: "plain" },
  pressed: { text: "PRESSED", level: "caution" },
};
const UNKNOWN = { text: "unknown", level: "caution" };

/// [{name, text, level}], level "plain", "caution" or "danger". What an old status says is told in the past tense.
export function facts(status) {
  if (!status) return [];
  const state = STATES[status.state] ?? UNKNOWN;
  const firmware = status.state === "silent" ? `silent for ${duration(status.age_s)}` : state.text;
  const all = [{ name: "firmware", text: firmware, level: state.level }];
  if (status.state !== "never_heard")
    all.push(fact("key", KEY[status.key], status), fact("e-stop", ESTOP[status.estop], status));
  if (status.armed_by) all.push({ name: "armed by", text: status.armed_by, level: "plain" });
  return all;
}

function fact(name, known, status) {
  const { text, level } = known ?? UNKNOWN;
  return status.state === "silent" && known
    ? { name, text: `was ${text}`, level: "caution" }
    : { name, text, level };
}

/// "7 shots, 6 counted of 20 wanted"
export function progress(status) {
  if (!status) return "";
  const wanted = Number.isFinite(status.wanted) ? ` of ${status.wanted} wanted` : "";
  return `${count(status.shots ?? 0, "shot")}, ${status.counted ?? 0} counted${wanted}`;
}

/// Why nothing can be fired, in words, or "".
export function missing(status) {
  if (!status) return "";
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
  return `This page has not been connected to the host since ${at}: numbers may be old.`;
}
