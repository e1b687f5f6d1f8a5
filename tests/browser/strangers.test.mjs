// Who must not read or stop anything: another site's page in the operator's browser, who does not know the secret, and who sends
// what no browser sends. A series is fired meanwhile and must not notice.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { Crowd, ask, json, post, raw } from './harness/http.mjs';
import { until } from './harness/programs.mjs';
import { Rig } from './harness/rig.mjs';

const foreign = 'http://evil.example';
const shots = 500;  // more than are fired until it is stopped
const commands = ['/api/v1/stop', '/api/v1/disarm'];
let rig, host, url;

before(async () => {
  rig = await Rig.start(process.env.STROBE_BROWSER_FOLDER);
  host = rig.fire(shots);
  url = await host.address();
});
after(async () => {
  await host.kill();
  await rig.end();
});

const refused = ({ status }) => status === 0 || (status >= 400 && status < 500);

function assertNothingRead(answer, what) {
  assert.ok(refused(answer), `${what}: ${answer.status}`);
  assert.ok(!answer.body.includes('boot_id') && !answer.body.includes('"rig"'), `${what}: ${answer.body}`);
}

test('who belongs here reads the state', async () => {
  assert.equal((await json(url, '/api/v1/live')).program, 'fire');
  await until(async () => (await json(url, '/api/v1/live')).can.stop, 'a series that can be stopped');
});

test('a name that another site points at this machine reads nothing', async () => {
  for (const path of ['/', '/api/v1/live', '/api/v1/sessions', '/api/v1/events'])
    for (const name of ['evil.example', `evil.example:${url.port}`, '127.0.0.1.evil.example'])
      assertNothingRead(await ask(url, path, { headers: { Host: name } }), `${path} of host "${name}"`);
});

test('a page of another site neither commands nor hears anything', async () => {
  for (const path of commands) {
    for (const origin of [foreign, 'null', `http://127.0.0.1:${Number(url.port) + 1}`])
      assert.equal((await post(url, path, '{}', { Origin: origin })).status, 403, `${path} from ${origin}`);
    // What a form of another site can send without asking first
    for (const type of ['text/plain', 'application/x-www-form-urlencoded', 'multipart/form-data; boundary=x'])
      assert.ok(refused(await post(url, path, '{}', { 'Content-Type': type, Origin: foreign })), `${path} as ${type}`);
    for (const method of ['GET', 'HEAD', 'PUT', 'DELETE', 'OPTIONS'])
      assert.ok(refused(await ask(url, path, { method })), `${method} ${path}`);
  }
  assertNothingRead(await ask(url, '/api/v1/events', { headers: { Origin: foreign } }), 'events');
});

test('no answer allows another site to read it', async () => {
  for (const path of ['/', '/api/v1/live']) {
    const { headers } = await ask(url, path, { headers: { Origin: foreign } });
    assert.equal(headers['access-control-allow-origin'], undefined);
  }
  const { headers } = await ask(url, '/');
  assert.match(headers['content-security-policy'], /default-src 'self'/);
  assert.equal(headers['x-content-type-options'], 'nosniff');
});

test('nothing fires, whatever is sent', async () => {
  for (const path of ['fire', 'arm', 'shoot', 'shots', 'start', 'command', 'live', 'commission/fire'])
    assert.ok(refused(await post(url, `/api/v1/${path}`, '{"shots":1}')), path);
});

test('what is too large or no HTTP is refused, and answers go on', async () => {
  const large = JSON.stringify({ corrections: 'x'.repeat(300_000) });
  for (const path of commands) assert.ok(refused(await post(url, path, large)), path);
  assert.ok(refused(await ask(url, '/', { headers: { Cookie: 'x'.repeat(100_000) } })));
  assert.ok(refused(await ask(url, `/${'x'.repeat(100_000)}`)));
  const odd = ['GET / HTTP/1.1\r\n\r\n', 'GET / HTTP/9.9\r\n\r\n', '\r\n\r\n\r\n', '\0\xff\xfe'.repeat(1000) + '\r\n\r\n', 'GET /%zz HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n',
    `POST /api/v1/stop HTTP/1.1\r\nHost: 127.0.0.1:${url.port}\r\nContent-Type: application/json\r\nContent-Length: -1\r\n\r\n{}`,
    `POST /api/v1/stop HTTP/1.1\r\nHost: 127.0.0.1:${url.port}\r\nContent-Type: application/json\r\nContent-Length: 2\r\nContent-Length: 3\r\n\r\n{}`,
    `GET /../../../../etc/passwd HTTP/1.1\r\nHost: 127.0.0.1:${url.port}\r\nConnection: close\r\n\r\n`];
  for (const bytes of odd) {
    const answer = await raw(url, bytes);
    assert.match(answer, /^$|^HTTP\/1\.[01] (4\d\d|505) /, JSON.stringify(bytes.slice(0, 60)));
  }
  for (const path of ['/api/v1/sessions/..%2f..%2fetc/shots', '/api/v1/sessions/%2e%2e/report', '/..%2f..%2fetc/passwd'])
    assertNothingRead(await ask(url, path), path);
  for (const body of ['', '{', '[]', '{"a":'.repeat(20_000)])
    assert.ok(refused(await post(url, '/api/v1/sessions/today/shots/1/corrections', body)), body.slice(0, 20));
  await json(url, '/api/v1/live');
});

test('a thousand connections are held while shots go on, and leave no trace', async () => {
  const crowd = new Crowd(url, 1000);
  await crowd.settled();
  const begun = host.lines().length;
  await until(() => host.lines().length >= begun + 2 || host.status, 'two further shots');
  crowd.leave();
  await until(async () => host.status || (await ask(url, '/api/v1/live')).status === 200, 'an answer after the crowd');
});

test('the series goes on until who belongs here stops it', async () => {
  assert.equal(host.status, undefined, host.err);
  const begun = host.lines().length;
  await until(() => host.lines().length > begun || host.status, 'a further shot');
  assert.equal((await post(url, '/api/v1/stop', '{}', { Origin: url.origin })).status, 202);
  assert.deepEqual(await host.end(), { code: 1, signal: null }, host.err);
  assert.ok(host.lines().length < shots);
});

test('who does not know the secret of another address reads nothing and commands nothing', async () => {
  const served = rig.live({ address: '0.0.0.0:0' });
  const address = await served.address();
  const secret = address.searchParams.get('secret');
  assert.ok(secret.length >= 16, `${address}`);
  const local = new URL(`http://127.0.0.1:${address.port}/`);
  const host = { Host: address.host };
  for (const path of ['/', '/app.js', '/api/v1/live', '/api/v1/events', '/api/v1/sessions', '/?secret=', `/?secret=${secret.slice(1)}x`]) {
    assertNothingRead(await ask(local, path, { headers: host }), path);
    assertNothingRead(await ask(local, path, { headers: { ...host, Authorization: 'Bearer wrong', Cookie: 'secret=wrong' } }), path);
  }
  for (const path of commands) assert.ok(refused(await post(local, path, '{}', host)), path);
  const entered = await ask(local, `/?secret=${secret}`, { headers: host });
  assert.ok(entered.status >= 300 && entered.status < 400, `${entered.status}`);
  assert.equal(entered.headers.location, '/');
  assert.match(entered.headers['set-cookie'][0], /HttpOnly/i);
  assert.match(entered.headers['set-cookie'][0], /SameSite=Strict/i);
  assert.equal((await json(local, '/api/v1/live', { ...host, Authorization: `Bearer ${secret}` })).program, 'live');
  assert.equal((await ask(local, '/api/v1/live', { headers: { Host: 'evil.example', Authorization: `Bearer ${secret}` } })).status >= 400, true);
  assert.equal(served.err.split(secret).length, 2, 'the secret is printed once');
  await served.kill();
});
