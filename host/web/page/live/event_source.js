// The host's events, over connections that are opened again whenever they break.

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
