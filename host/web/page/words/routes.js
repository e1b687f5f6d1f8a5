// Addresses of views behind the page's #: "#/series/2026-11-23?spin=zero". Pure.

export const VIEWS = [
  { name: "shot", title: "Shot" },
  { name: "series", title: "Series" },
  { name: "history", title: "History" },
  { name: "compare", title: "Compare" },
  { name: "timing", title: "Timing" },
  { name: "commission", title: "Commission" },
  { name: "report", title: "Report" },
];

/// {view, parts: [...], query: {...}}; an unknown view is the first.
export function parseRoute(hash) {
  const [path, search = ""] = hash.replace(/^#?\/?/, "").split("?");
  const [view, ...parts] = path.split("/").filter(Boolean).map(decoded);
  const known = VIEWS.some((v) => v.name === view) ? view : VIEWS[0].name;
  return {
    view: known,
    parts: known === view ? parts : [],
    query: Object.fromEntries(new URLSearchParams(search)),
  };
}

export function routeTo(view, parts = [], query = {}) {
  const filled = Object.entries(query).filter(
    ([, value]) => value !== null && value !== undefined && value !== "",
  );
  const search = new URLSearchParams(filled.map(([key, value]) => [key, String(value)])).toString();
  return `#/${[view, ...parts].map(encodeURIComponent).join("/")}${search ? `?${search}` : ""}`;
}

function decoded(part) {
  try {
    return decodeURIComponent(part);
  } catch {
    return part;
  }
}
