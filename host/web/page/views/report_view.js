// The report of a session, as a laboratory would sign it.
import { getJson, path } from "../live/api.js";
import { attempt, choice, fill, h, quiet, viewHeading } from "../parts/dom.js";
import { routeTo } from "../words/routes.js";

export function reportView(main, { live, route, signal }) {
  const top = h("div", { class: "report-choice" });
  const place = h("div", { class: "report" }, quiet("Reading the sessions."));
  fill(main, viewHeading("Report"), top, place);
  return attempt(place, "Report", async () => {
    const sessions = await getJson(path("sessions"), signal);
    const shown = route.parts[0] ?? live.session ?? sessions[0]?.id;
    if (!shown) return fill(place, quiet("No session yet."));
    const open = (session) => {
      location.hash = routeTo("report", [session]);
    };
    const address = path("sessions", shown, "report");
    const options = sessions.map(({ id }) => [id, id]);
    const alone = { href: address, target: "_blank", rel: "noopener" };
    fill(
      top,
      choice("Session", options, shown, open).element,
      h("a", alone, "Open it by itself (to print or sign)"),
    );
    const note = quiet("The report is being written; that may take a minute.");
    const frame = h("iframe", { src: address, title: `Report of ${shown}`, onload: () => note.remove() });
    return fill(place, note, frame);
  });
}
