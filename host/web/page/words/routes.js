// Addresses of views behind the page's #: "#/series/2026-11-23?spin=zero". Pure.

export const VIEWS = ["shot", "series", "history", "compare", "timing", "commission", "report"];

export const titleOf = (view) => `${view[0].toUpperCase()}${view.slice(1)}`;

/// {view, parts: [...], query: {...}}; an unknown view is the first.
export function parseRoute(hash) {
  const [path, search = ""] = hash.replace(/^#?\/?/, "").split("?");
  const [view, ...parts] = path.split("/").filter(Boolean).map(decoded);
  const known = VIEWS.includes(view) ? view : VIEWS[0];
  return {
    view: known,
    parts: known === view ? parts : [],
    query: Object.fromEntries(new URLSearchParams(search)),
  };
}

export function routeTo(view, parts = [], query = {}) {
  return withQuery(`#/${[view, ...parts].map(encodeURIComponent).join("/")}`, query);
}

/// What is null, undefined or empty is left out.
export function withQuery(address, query) {
  const filled = Object.entries(query).filter(([, value]) => (value ?? "") !== "");
  return filled.length > 0 ? `${address}?${new URLSearchParams(filled)}` : address;
}

function decoded(part) {
  try {
    return decodeURIComponent(part);
  } catch {
    return part;
  }
}
