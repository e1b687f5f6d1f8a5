import assert from "node:assert/strict";
import { test } from "node:test";
import { Live } from "../../../host/web/page/live/live.js";

/// A host whose answers the test decides: answers["/api/v1/live"] is a function; its promise may be kept open.
function start(context, answers) {
  const { fetch: real, EventSource: none } = globalThis;
  context.after(() => Object.assign(globalThis, { fetch: real, EventSource: none }));
  globalThis.EventSource = class extends EventTarget {
    close() {}
  };
  const asked = [];
  globalThis.fetch = async (address) => {
    asked.push(address);
    const body = await answers[address]();
    return { ok: true, status: 200, json: async () => body };
  };
  const live = new Live();
  const told = [];
  for (const kind of ["live", "shot", "status", "series", "notification", "connection"])
    live.addEventListener(kind, ({ detail }) => told.push(detail?.name ? `${kind} ${detail.name}` : kind));
  live.start();
  clearTimeout(live.events.quiet);
  context.after(() => clearTimeout(live.events.quiet));
  return { live, told, asked };
}

const host = (last, eventId, more = {}) => ({
  session: "today",
  status: { state: "idle", age_s: 1 },
  series: null,
  notifications: [],
  last: last && { name: last },
  event_id: eventId,
  ...more,
});
const quantities = async () => [{ name: "e", label: "restitution e", unit: "", essential: true }];
const settled = () => new Promise(setImmediate);

test("an event that the host's state has already is not applied again; a later one is", async (context) => {
  let answer;
  const { live, told } = start(context, {
    "/api/v1/quantities": quantities,
    "/api/v1/live": () => new Promise((done) => (answer = done)),
  });
  live.load();
  await settled();
  live.receive("shot", { name: "4" }, 10);
  live.receive("shot", { name: "6" }, 12);
  answer(host("5", 11));
  await settled();
  assert.equal(live.state.last.name, "6");
  assert.deepEqual(told, ["connection", "live", "shot 6"]);
});

test("a new shot is told at once, without asking the host", async (context) => {
  const { live, told, asked } = start(context, {
    "/api/v1/quantities": quantities,
    "/api/v1/live": async () => host("1", 1),
  });
  await live.load();
  const before = asked.length;
  live.receive("shot", { name: "2" }, 2);
  assert.equal(told.at(-1), "shot 2");
  assert.equal(asked.length, before);
});

test("a reset fetches everything anew", async (context) => {
  let newest = "1";
  const { live } = start(context, {
    "/api/v1/quantities": quantities,
    "/api/v1/live": async () => host(newest, 1),
  });
  await live.load();
  newest = "9";
  live.receive("reset", {}, 50);
  await settled();
  assert.equal(live.state.last.name, "9");
});

test("a reset that comes while all is fetched asks for it again only where it is newer", async (context) => {
  let answer;
  const { live, asked } = start(context, {
    "/api/v1/quantities": quantities,
    "/api/v1/live": () => new Promise((done) => (answer = done)),
  });
  const times = () => asked.filter((address) => address === "/api/v1/live").length;
  live.load();
  await settled();
  live.receive("reset", {}, 11);
  answer(host("5", 11));
  await settled();
  assert.equal(times(), 1);
  live.receive("reset", {}, 20);
  live.receive("reset", {}, 30);
  answer(host("6", 25));
  await settled();
  assert.equal(times(), 3);
  answer(host("7", 30));
  await settled();
  assert.deepEqual([live.state.last.name, times()], ["7", 3]);
});

test("a host that ends is told of as such, and not again as lost", async (context) => {
  const { live, told } = start(context, {
    "/api/v1/quantities": quantities,
    "/api/v1/live": async () => host("1", 1),
  });
  await live.load();
  live.receive("end", {}, 2);
  live.lost();
  assert.deepEqual([live.connection.connected, live.connection.ended], [false, true]);
  assert.equal(told.filter((kind) => kind === "connection").length, 2);
});

test("a series is fetched once for events that come while it is on its way", async (context) => {
  let series = 0;
  const { live, told, asked } = start(context, {
    "/api/v1/quantities": quantities,
    "/api/v1/live": async () => host("1", 1, { series: ++series }),
  });
  await live.load();
  const before = asked.length;
  for (let i = 0; i < 5; ++i) live.receive("series", {}, 2 + i);
  await settled();
  await settled();
  assert.equal(asked.length - before, 2); // the one under way, and one for all that came meanwhile
  assert.equal(live.state.series, series);
  assert.equal(told.at(-1), "series");
});

test("the newest fifty notifications are kept", async (context) => {
  const { live } = start(context, {
    "/api/v1/quantities": quantities,
    "/api/v1/live": async () => host(null, 1),
  });
  await live.load();
  for (let i = 0; i < 60; ++i) live.receive("notification", { utc: "", text: `${i}` }, 2 + i);
  assert.deepEqual(
    [live.state.notifications.length, live.state.notifications[0].text, live.state.notifications.at(-1).text],
    [50, "10", "59"],
  );
});

test("a lost connection tells since when, and the age of the status grows meanwhile", async (context) => {
  const { live, told } = start(context, {
    "/api/v1/quantities": quantities,
    "/api/v1/live": async () => host("1", 1),
  });
  await live.load();
  live.statusHeard -= 5000;
  live.lost();
  const { since } = live.connection;
  live.lost();
  assert.equal(live.connection.since, since);
  assert.ok(live.status.age_s >= 6);
  assert.deepEqual(told.filter((kind) => kind === "connection").length, 2);
});
