// What the host tells now: one copy of /api/v1/live, kept up to date by events. Dispatches "live" (all anew), "status", "shot"
// (detail: the row), "series", "notification", "edited", "commission" and "connection".
import { getJson, path } from "./api.js";

const NOTIFICATIONS_KEPT = 50;

export class Live extends EventTarget {
  constructor() {
    super();
    this.state = null;
    this.quantities = [];
    this.connection = { connected: false, since: null };
    this.statusHeard = 0;
    this.waiting = null;
  }

  start() {
    this.events = new HostEvents(path("events"), {
      onOpen: () => this.load(),
      onEvent: (kind, data, id) => this.receive(kind, data, id),
      onLost: () => this.lost(),
      probe: () => getJson(path("live")),
    });
  }

  get session() {
    return this.state?.session ?? null;
  }

  /// The status with its age as of now.
  get status() {
    const status = this.state?.status;
    if (!status) return null;
    return { ...status, age_s: (status.age_s ?? NaN) + (performance.now() - this.statusHeard) / 1000 };
  }

  /// Fetches all anew. Events that come meanwhile are applied after it, unless it has them already.
  async load() {
    if (this.waiting) {
      this.again = true;
      return;
    }
    this.waiting = [];
    try {
      if (this.quantities.length === 0) this.quantities = await getJson(path("quantities"));
      this.replace(await getJson(path("live")));
    } catch {
      this.waiting = null;
      this.events.lost();
      return;
    }
    this.events.confirm();
    const later = this.waiting.filter(({ id }) => !(id <= this.state.event_id));
    this.waiting = null;
    for (const { kind, data, id } of later) this.receive(kind, data, id);
    if (this.again) {
      this.again = false;
      this.load();
    }
  }

  replace(state) {
    this.state = state;
    this.statusHeard = performance.now();
    this.connection = { connected: true, since: null };
    this.tell("connection");
    this.tell("live");
  }

  receive(kind, data, id) {
    if (kind === "end") this.lost(true);
    else if (this.waiting) this.waiting.push({ kind, data, id });
    else if (kind === "reset") this.load();
    else if (this.state) this.apply(kind, data);
  }

  apply(kind, data) {
    if (kind === "status") {
      this.state.status = data;
      this.statusHeard = performance.now();
    }
    if (kind === "shot") this.state.last = data;
    if (kind === "notification")
      this.state.notifications = [...(this.state.notifications ?? []), data].slice(-NOTIFICATIONS_KEPT);
    if (kind === "series") this.loadSeries();
    else this.tell(kind, data);
  }

  /// The series is too large for an event: it is fetched, once for events that come meanwhile.
  async loadSeries() {
    this.seriesIsOld = true;
    if (this.loadingSeries) return;
    this.loadingSeries = true;
    try {
      while (this.seriesIsOld) {
        this.seriesIsOld = false;
        this.state.series = (await getJson(path("live"))).series;
        this.tell("series");
      }
    } catch {
      // The connection's own loss is told; the series comes with the next one.
    }
    this.loadingSeries = false;
  }

  /// ended: the host has said that it ends.
  lost(ended = false) {
    if (this.connection.since) return;
    this.connection = { connected: false, since: new Date(), ended };
    this.tell("connection");
  }

  tell(kind, detail) {
    this.dispatchEvent(Object.assign(new Event(kind), { detail }));
  }
}

const KINDS = ["status", "shot", "series", "notification", "edited", "commission", "reset", "end"];
const FIRST_DELAY_MS = 250;
const LARGEST_DELAY_MS = 5000;
const QUIET_MS = 15000;

/// Delay before the n-th attempt in a row, n from 0.
export function retryDelayMs(attempt) {
  return Math.min(FIRST_DELAY_MS * 2 ** attempt, LARGEST_DELAY_MS);
}

/// Calls onOpen() on each new connection, onEvent(kind, data, id), and onLost() each time it breaks or cannot be made. Delays
/// grow until confirm() says that the host is of use again. A connection on which nothing comes is asked after by probe(), a
/// promise that fails where the host is gone.
export class HostEvents {
  constructor(address, { onOpen, onEvent, onLost, probe }) {
    Object.assign(this, { address, onOpen, onEvent, onLost, probe });
    this.attempt = 0;
    this.connect();
  }

  connect() {
    this.source = new EventSource(this.address);
    this.source.addEventListener("open", () => {
      this.heard();
      this.onOpen();
    });
    this.source.addEventListener("error", () => this.lost());
    for (const kind of KINDS) this.source.addEventListener(kind, (event) => this.receive(kind, event));
  }

  confirm() {
    this.attempt = 0;
  }

  receive(kind, event) {
    this.heard();
    let data;
    try {
      data = JSON.parse(event.data);
    } catch {
      return;
    }
    this.onEvent(kind, data, Number(event.lastEventId));
  }

  heard() {
    clearTimeout(this.quiet);
    const source = this.source;
    this.quiet = setTimeout(() => {
      this.probe().then(
        () => this.source === source && this.heard(),
        () => this.source === source && this.lost(),
      );
    }, QUIET_MS);
  }

  lost() {
    clearTimeout(this.quiet);
    this.source.close();
    this.onLost();
    setTimeout(() => this.connect(), retryDelayMs(this.attempt++));
  }
}
