// The firmware's timing in sentences. Pure.
import { count, fixed, microseconds } from "./numbers.js";

export const TIMINGS = [
  {
    key: "lateness_us",
    title: "Lateness of a flash's pulse",
    words: "from the commanded instant to the call that sets the line",
  },
  {
    key: "issue_us",
    title: "Length of the call that sets the lines",
    words: "what the kernel takes for one instant",
  },
  {
    key: "skew_us",
    title: "Lamp A against lamp B",
    words: "light of A less light of B, of flashes that both sensors saw",
  },
  {
    key: "lamp_delay_a_us",
    title: "Delay of lamp A",
    words: "from the call's end to the light that the sensor saw",
  },
  {
    key: "lamp_delay_b_us",
    title: "Delay of lamp B",
    words: "from the call's end to the light that the sensor saw",
  },
  {
    key: "period_error_us",
    title: "Error of the intervals between flashes",
    words: "as seen by the sensors",
  },
];

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
