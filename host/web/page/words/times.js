// Times for a person, always UTC, as in the files of a session. Pure.

/// "2026-11-23 14:02:11"
export function dateAndTime(utc) {
  return utc ? utc.slice(0, 19).replace("T", " ") : "";
}

/// "14:02:11"
export function timeOfDay(utc) {
  return utc ? utc.slice(11, 19) : "";
}

/// "8 s", "3 min", "5 h", "12 days"
export function duration(seconds) {
  if (!Number.isFinite(seconds)) return "an unknown time";
  if (seconds < 100) return `${Math.round(seconds)} s`;
  if (seconds < 100 * 60) return `${Math.round(seconds / 60)} min`;
  if (seconds < 48 * 3600) return `${Math.round(seconds / 3600)} h`;
  return `${Math.round(seconds / 86400)} days`;
}
