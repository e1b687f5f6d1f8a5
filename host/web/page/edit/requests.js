// What the editor asks of the host. Failures are errors whose message can be shown.
import { getJson, path, postJson } from "../live/api.js";

export function createRequests(session, shot) {
  const at = (name) => path("sessions", session, "shots", shot, name);
  return {
    /// {found: {images, surface_px, unmeasured}, corrections: [...]}: what the digitizer found, and the corrections that count.
    corrections: () => getJson(at("corrections")),
    preview: (text) => postJson(at("preview"), { corrections: text }),
    save: (text) => postJson(at("corrections"), { corrections: text }),
    undo: () => postJson(at("undo"), {}),
    quantities: () => getJson(path("quantities")),
  };
}
