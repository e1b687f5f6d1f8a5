// Starts the page: bar, tabs, and the view that the address names.
import { Live } from "./live/live.js";
import { announce } from "./parts/announcer.js";
import { fill, h } from "./parts/dom.js";
import { RigBar } from "./parts/rig_bar.js";
import { applyTheme, themeChoice } from "./parts/theme.js";
import { parseRoute, routeTo, VIEWS } from "./words/routes.js";
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

applyTheme();
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
  const links = VIEWS.map(({ name, title }) =>
    h("li", {}, h("a", { href: routeTo(name), "data-view": name }, title)),
  );
  fill(document.getElementById("tabs"), h("ul", {}, links), themeChoice());
}

/// Of the address, or what the host is about.
function routeNow() {
  const first = live.state?.program === "commission" ? routeTo("commission") : "";
  return parseRoute(location.hash || first);
}

/// The name of the window, seen also where another one is in front.
function showTitle() {
  const { title } = VIEWS.find(({ name }) => name === routeNow().view);
  const danger = live.status?.danger ? "DANGER – " : "";
  document.title = `${danger}${title} – ${live.state?.rig || "strobe"}`;
}

/// A view is a function of (element, {live, route, signal}); it undoes what it set up when the signal is aborted.
function show(moved) {
  if (!live.state) return;
  const route = routeNow();
  leave.abort();
  leave = new AbortController();
  main.replaceChildren();
  main.className = `view-${route.view}`;
  for (const link of document.querySelectorAll("#tabs a")) {
    if (link.dataset.view === route.view) link.setAttribute("aria-current", "page");
    else link.removeAttribute("aria-current");
  }
  showTitle();
  OPEN[route.view](main, { live, route, signal: leave.signal });
  if (!moved) return;
  scrollTo(0, 0);
  main.querySelector("h1")?.focus();
}
