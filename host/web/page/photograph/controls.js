// Small pieces of the photograph's view and of its editor.
import { h } from "../parts/dom.js";

/// A button with its keyboard shortcut told.
export function button(words, action, { key, name, className } = {}) {
  return h("button", { type: "button", onclick: action, class: className, "aria-label": name, "aria-keyshortcuts": key,
    title: key ? `${name ?? words} (${key})` : name }, words);
}

/// Only what differs is set, since a change that is none costs a layout; null and false take an attribute away.
export function setAttributes(element, attributes) {
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) element.removeAttribute(name);
    else if (element.getAttribute(name) !== String(value)) element.setAttribute(name, String(value));
  }
}
