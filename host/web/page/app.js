// Starts the page: bar, tabs, and the view that the address names.
import { Live } from "./live/live.js";
import { announce, fill, h, list, setAttributes } from "./parts/dom.js";
import { RigBar } from "./parts/rig_bar.js";
import { parseRoute, routeTo, titleOf, VIEWS } from "./words/routes.js";
import { announcement } from "./words/shots.js";
import { commissionView } from "./views/commission_view.js";
import { compareView } from "./views/compare_view.js";
import { historyView } from "./views/history_view.js";
import { reportView } from "./views/report_view.js";
import { seriesView } from "./views/series_view.js";
import { shotView } from "./views/shot_view.js";
import { timingView } from "./views/timing_view.js";

const OPEN = {
  shot: shotView,
  series: seriesView,
  history: historyView,
  compare: compareView,
  timing: timingView,
  commission: commissionView,
  report: reportView,
};

const live = new Live();
const main = document.getElementById("main");
let leave = new AbortController();

new RigBar(document.getElementById("bar"), live);
showTabs();
document.querySelector(".skip").addEventListener("click", (event) => {
  event.preventDefault(); // the part behind the # is the view's
  main.focus();
});
addEventListener("hashchange", () => show(true));
live.addEventListener("live", () => show(false), { once: true });
live.addEventListener("shot", ({ detail }) => announce(announcement(detail, live.quantities)));
for (const kind of ["live", "status"]) live.addEventListener(kind, showTitle);
live.start();

function showTabs() {
  const tabs = VIEWS.map((view) => h("a", { href: routeTo(view), "data-view": view }, titleOf(view)));
  fill(document.getElementById("tabs"), list(null, tabs));
}

/// Of the address, or what the host is about.
function routeNow() {
  const first = live.state?.program === "commission" ? routeTo("commission") : "";
  return parseRoute(location.hash || first);
}

/// The name of the window, seen also where another one is in front.
function showTitle() {
  const danger = live.status?.danger ? "DANGER – " : "";
  document.title = `${danger}${titleOf(routeNow().view)} – ${live.state?.rig || "strobe"}`;
}

/// A view is a function of (element, {live, route, signal}); it undoes what it set up when the signal is aborted.
function show(moved) {
  if (!live.state) return;
  const route = routeNow();
  leave.abort();
  leave = new AbortController();
  main.replaceChildren();
  main.className = `view-${route.view}`;
  for (const link of document.querySelectorAll("#tabs a"))
    setAttributes(link, { "aria-current": link.dataset.view === route.view && "page" });
  showTitle();
  OPEN[route.view](main, { live, route, signal: leave.signal });
  if (!moved) return;
  scrollTo(0, 0);
  main.querySelector("h1")?.focus();
}
