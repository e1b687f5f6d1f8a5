// Requests by hand: what a browser would never send.
import { request } from 'node:http';
import { connect } from 'node:net';
import { once } from 'node:events';

/// {status, headers, body} of one request; status 0: the host ended the connection without an answer.
export function ask(url, path, { method = 'GET', headers = {}, body } = {}) {
  return new Promise((resolve) => {
    let answered = false;
    const sent = request({ host: url.hostname, port: url.port, path, method, headers, agent: false }, (answer) => {
      answered = true;
      let text = '';
      answer.setEncoding('utf8').on('data', (part) => (text += part));
      answer.on('close', () => resolve({ status: answer.statusCode, headers: answer.headers, body: text }));
      answer.on('error', () => {});
    });
    // The rest of a request that was answered early meets a connection that is closed.
    sent.on('error', () => answered || resolve({ status: 0, headers: {}, body: '' }));
    sent.end(body);
  });
}

export const post = (url, path, body, headers = {}) =>
  ask(url, path, { method: 'POST', body, headers: { 'Content-Type': 'application/json', 'Content-Length': Buffer.byteLength(body), ...headers } });

export async function json(url, path, headers) {
  const answer = await ask(url, path, { headers });
  if (answer.status !== 200) throw new Error(`${path}: ${answer.status} ${answer.body}`);
  return JSON.parse(answer.body);
}

/// Sends bytes as they are and returns what comes until the host ends the connection.
export async function raw(url, bytes) {
  const socket = connect(Number(url.port), url.hostname);
  let text = '';
  socket.setEncoding('latin1').on('data', (part) => (text += part));
  socket.on('error', () => {});
  socket.write(bytes);
  await once(socket, 'close');
  return text;
}

/// Connections that say nothing, as many as are accepted or wait to be.
export class Crowd {
  constructor(url, count) {
    this.sockets = Array.from({ length: count }, () => connect(Number(url.port), url.hostname).on('error', () => {}));
  }
  async settled() {
    await Promise.all(this.sockets.map((socket) => (socket.connecting ? Promise.race([once(socket, 'connect'), once(socket, 'close')]).catch(() => {}) : null)));
  }
  leave() {
    for (const socket of this.sockets) socket.destroy();
  }
}
