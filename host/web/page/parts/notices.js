// Small pieces that several views use.
import { h } from "./dom.js";

export function problem(words) {
  return h("p", { class: "problem", role: "status" }, words);
}

export function quiet(words) {
  return h("p", { class: "quiet" }, words);
}

/// The heading of a view; gets the focus when the view is opened.
export function viewHeading(text) {
  return h("h1", { tabindex: "-1" }, text);
}

/// title: more of it, for who points at it.
export function badge(level, text, title = null) {
  return h("span", { class: `badge ${level}`, title }, text);
}

export function details(title, content, { open = false, id = null, ontoggle = null } = {}) {
  return h("details", { open, id, ontoggle }, h("summary", {}, title), content);
}
