import assert from "node:assert/strict";
import { test } from "node:test";
import { HostEvents, retryDelayMs } from "../../../host/web/page/live/live.js";

/// Stands in for the browser's EventSource; the test says what happens on it.
class Source extends EventTarget {
  static made = [];
  constructor(address) {
    super();
    this.address = address;
    Source.made.push(this);
  }
  close() {
    this.isClosed = true;
  }
  say(kind, data, lastEventId) {
    this.dispatchEvent(Object.assign(new Event(kind), { data, lastEventId }));
  }
}

/// A clock that the test moves on; restores the real one when the test ends.
function fakeTimers(context) {
  const { setTimeout: set, clearTimeout: clear } = globalThis;
  context.after(() => Object.assign(globalThis, { setTimeout: set, clearTimeout: clear }));
  const due = new Map();
  let now = 0,
    last = 0;
  globalThis.setTimeout = (call, ms) => due.set(++last, { call, at: now + ms }) && last;
  globalThis.clearTimeout = (id) => due.delete(id);
  return (ms) => {
    now += ms;
    for (const [id, { call, at }] of [...due]) if (at <= now && due.delete(id)) call();
  };
}

function connect(context, more = {}) {
  const tick = fakeTimers(context);
  Source.made = [];
  globalThis.EventSource = Source;
  const told = [];
  const events = new HostEvents("/events", {
    onOpen: () => told.push("open"),
    onLost: () => told.push("lost"),
    probe: () => Promise.resolve(),
    onEvent: (kind, data, id) => told.push([kind, data, id]),
    ...more,
  });
  return { events, told, tick };
}

test("events are told with their data and number, and what is not JSON is left out", (context) => {
  const { told } = connect(context);
  Source.made[0].say("open");
  Source.made[0].say("shot", '{"name":"3"}', "17");
  Source.made[0].say("status", "{", "18");
  assert.deepEqual(told, ["open", ["shot", { name: "3" }, 17]]);
});

test("a broken connection is closed, told, and made anew", (context) => {
  const { told, tick } = connect(context);
  Source.made[0].say("open");
  Source.made[0].say("error");
  assert.ok(Source.made[0].isClosed);
  assert.deepEqual(told, ["open", "lost"]);
  assert.equal(Source.made.length, 1);
  tick(retryDelayMs(0));
  assert.equal(Source.made.length, 2);
});

test("delays grow to a largest one until the host is confirmed", (context) => {
  const { events, tick } = connect(context);
  for (let attempt = 0; attempt < 8; ++attempt) {
    Source.made.at(-1).say("error");
    tick(retryDelayMs(attempt) - 1);
    assert.equal(Source.made.length, attempt + 1);
    tick(1);
    assert.equal(Source.made.length, attempt + 2);
  }
  assert.equal(retryDelayMs(8), retryDelayMs(30));
  events.confirm();
  Source.made.at(-1).say("error");
  tick(retryDelayMs(0));
  assert.equal(Source.made.length, 10);
});

test("a quiet connection whose host is gone is lost; one whose host answers is kept", async (context) => {
  let alive = true;
  const { told, tick } = connect(context, {
    probe: () => (alive ? Promise.resolve() : Promise.reject(new Error("gone"))),
  });
  Source.made[0].say("open");
  tick(20000);
  await new Promise(setImmediate);
  assert.deepEqual(told, ["open"]);
  alive = false;
  tick(20000);
  await new Promise(setImmediate);
  assert.deepEqual(told, ["open", "lost"]);
});
