// What the tests of one process share, made when it is first asked for: a browser, a rig, viewers' pages.
import assert from 'node:assert/strict';
import { cp } from 'node:fs/promises';
import { after, test } from 'node:test';
import { join } from 'node:path';
import { launch, open } from './browser.mjs';
import { json } from './http.mjs';
import { Rig } from './rig.mjs';
import { manyShots } from './session.mjs';

export const folder = process.env.STROBE_BROWSER_FOLDER;

function once(make) {
  let made;
  return () => (made ??= make());
}

export const browser = once(launch);
export const rig = once(() => Rig.start(folder));
const pages = [];
const hosts = [];

/// After the series: the rig's sessions as `strobe live` serves them, one more of them with two surfaces. {url, session: folder of the one that was fired, shot: the
/// name of one of its shots that counts}.
export const served = once(async () => {
  const { sessions, session } = await rig();
  for (const surface of ['acrylic', 'cushion'])
    await (await rig()).fire(2, { session: join(sessions, 'surfaces'), more: ['--spin', 'zero', '--angle', '23', '--note', `surface_name=${surface}`] }).end();
  await manyShots(session, join(sessions, 'thousand'), 1000);
  await cp(session, join(sessions, markup), { recursive: true });
  const url = await keep((await rig()).live()).address();
  const { shots } = await json(url, '/api/v1/sessions/today/shots');
  return { url, session, shot: shots.find((each) => each.counted).name };
});
/// The name of one of its sessions
export const markup = '<img src=x onerror=alert(1)>';

/// A viewer's page, closed at the end.
export async function view(url, options) {
  const page = await open(await browser(), url, options);
  pages.push(page);
  return page;
}

export async function leave(page) {
  await page.context().close();
}

/// Killed at the end if it still runs.
export function keep(host) {
  hosts.push(host);
  return host;
}

/// A test after which no page has an error on its console or asked for anything in vain. `expected`: what the test itself
/// causes, such as requests to a host that is gone.
export function check(name, body, { expected } = {}) {
  test(name, async () => {
    try {
      await body();
    } catch (error) {
      for (const host of hosts) console.error(`${host.name}: ${host.err.split('\n').slice(-8).join('\n  ')}`);
      throw error;
    }
    const trouble = pages.flatMap((page) => page.trouble.splice(0));
    assert.deepEqual(trouble.filter((words) => !expected?.test(words)), []);
  });
}

after(async () => {
  for (const host of hosts) await host.kill();
  if (pages.length > 0) await (await browser()).close();
  await (await rig()).end();
});
