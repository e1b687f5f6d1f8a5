// The report of a session, as a laboratory would sign it.
import { getJson, path } from "../live/api.js";
import { fill, h } from "../parts/dom.js";
import { problem, quiet, viewHeading } from "../parts/notices.js";
import { routeTo } from "../words/routes.js";

export async function reportView(main, { live, route, signal }) {
  const session = route.parts[0] ?? live.session;
  const choice = h("div", { class: "report-choice" });
  const place = h("div", { class: "report" }, quiet("Reading the sessions."));
  fill(main, viewHeading("Report"), choice, place);
  try {
    const sessions = await getJson(path("sessions"), signal);
    const shown = session ?? sessions[0]?.id;
    if (!shown) return fill(place, quiet("No session yet."));
    showChoice(choice, sessions, shown);
    return showReport(place, choice, shown);
  } catch (error) {
    return error.name === "AbortError" ? null : fill(place, problem(`Report: ${error.message}.`));
  }
}

function showChoice(choice, sessions, shown) {
  const select = h(
    "select",
    {
      onchange: () => {
        location.hash = routeTo("report", [select.value]);
      },
    },
    sessions.map((s) => h("option", { value: s.id }, s.id)),
  );
  select.value = shown;
  fill(choice, h("label", { class: "choice" }, h("span", {}, "Session"), select));
}

function showReport(place, choice, session) {
  const address = path("sessions", session, "report");
  choice.append(
    h("a", { href: address, target: "_blank", rel: "noopener" }, "Open it by itself (to print or sign)"),
  );
  fill(place, h("iframe", { src: address, title: `Report of ${session}` }));
}
