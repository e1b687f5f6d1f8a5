// Light, dark, or as the system says; kept in this browser.
import { h } from "./dom.js";

const KEY = "strobe-theme";
const CHOICES = [
  ["auto", "as the system"],
  ["light", "light"],
  ["dark", "dark"],
];

export function stored(key) {
  try {
    return localStorage.getItem(key);
  } catch {
    return null; // storage may be forbidden; the choice then lasts until reload
  }
}

export function store(key, value) {
  try {
    localStorage.setItem(key, value);
  } catch {
    // As above.
  }
}

export function applyTheme(choice = stored(KEY)) {
  if (choice === "light" || choice === "dark") document.documentElement.dataset.theme = choice;
  else delete document.documentElement.dataset.theme;
}

export function themeChoice() {
  const select = h(
    "select",
    {
      id: "theme",
      onchange: () => {
        store(KEY, select.value);
        applyTheme(select.value);
      },
    },
    CHOICES.map(([value, words]) => h("option", { value }, words)),
  );
  select.value = stored(KEY) ?? "auto";
  return h("label", { class: "choice" }, h("span", {}, "Colours"), select);
}
