// Viewers without a browser: each holds the event stream and asks for what the page asks for when a shot comes.
import { get } from 'node:http';

export class Viewers {
  #streams = [];
  #url;
  bytes = 0;

  constructor(url, count) {
    this.#url = url;
    for (let i = 0; i < count; ++i) this.#streams.push(this.#listen());
  }

  #ask(path, take = () => {}) {
    const request = get({ host: this.#url.hostname, port: this.#url.port, path, agent: false }, (answer) => {
      answer.on('data', (part) => {
        this.bytes += part.length;
        take(part);
      });
      answer.on('error', () => {});
    });
    request.on('error', () => {});
    return request;
  }

  #listen() {
    let text = '';
    return this.#ask('/api/v1/events', (part) => {
      text += part;
      const events = text.split('\n\n');
      text = events.pop();
      for (const event of events) {
        const data = event.startsWith('event: shot') || event.includes('\nevent: shot\n') ? event.match(/^data: (.*)$/m) : null;
        if (data) this.#open(JSON.parse(data[1]));
      }
    });
  }

  #open({ session, name }) {
    if (!session) return;
    const shot = `/api/v1/sessions/${encodeURIComponent(session)}/shots/${encodeURIComponent(name)}`;
    for (const path of [shot, `${shot}/photograph?width=1200`, '/api/v1/live']) this.#ask(path);
  }

  leave() {
    for (const stream of this.#streams) stream.destroy();
  }
}
