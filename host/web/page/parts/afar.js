// Numbers that fill the screen, to be read from across the room; kept in this browser.
import { h } from "./dom.js";
import { store, stored } from "./theme.js";

const KEY = "strobe-afar";

export function afarButton(signal) {
  let on = stored(KEY) === "yes";
  const button = h(
    "button",
    {
      type: "button",
      class: "afar-button",
      onclick: () => {
        on = !on;
        store(KEY, on ? "yes" : "no");
        apply();
      },
    },
    "Read from afar",
  );
  const apply = () => {
    document.body.classList.toggle("afar", on);
    button.setAttribute("aria-pressed", String(on));
  };
  apply();
  signal.addEventListener("abort", () => document.body.classList.remove("afar"));
  return button;
}
