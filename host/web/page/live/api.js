// The HTTP of the host, version 1. Every failure is an Error whose message is a line for a person.

const ROOT = "/api/v1";

/// Joins and encodes: path("sessions", "a b", "shots") is "/api/v1/sessions/a%20b/shots".
export function path(...parts) {
  return [ROOT, ...parts.map((part) => encodeURIComponent(part))].join("/");
}

export function getJson(address, signal) {
  return request(address, { signal, cache: "no-store" });
}

export function postJson(address, body) {
  return request(address, {
    method: "POST",
    headers: { "Content-Type": "application/json" },
    body: JSON.stringify(body),
  });
}

async function request(address, options) {
  let response;
  try {
    response = await fetch(address, options);
  } catch (error) {
    if (error.name === "AbortError") throw error;
    throw new Error("the host does not answer");
  }
  const body = await response.json().catch(() => null);
  if (!response.ok) throw new Error(body?.error ?? `the host answered ${response.status}`);
  if (body === null) throw new Error("the host's answer is not JSON");
  return body;
}
