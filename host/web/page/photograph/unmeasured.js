// What was not measured, and why, where the shot's detail does not tell: the host measures the photograph again for it, so
// it is asked only by who wants to know.
import { getJson, path } from "../live/api.js";
import { button } from "./controls.js";

export function createUnmeasured({ session, shot, changed }) {
  let places = [];
  const asking = button("What was not measured", ask);

  async function ask() {
    asking.disabled = true;
    asking.textContent = "Asking …";
    try {
      ({ unmeasured: places } = await getJson(path("sessions", session, "shots", shot, "unmeasured")));
      asking.textContent = places.length > 0 ? "What was not measured" : "Nothing was left out";
    } catch (error) {
      asking.textContent = `Not told: ${error.message}. Ask again`;
      asking.disabled = false;
    }
    changed();
  }

  return {
    button: asking,
    places: () => places,
    /// Whether it is of use: not once it is known.
    offer(whether) {
      asking.hidden = !whether || places.length > 0;
    },
  };
}
