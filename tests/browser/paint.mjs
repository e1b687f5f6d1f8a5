// How soon the history of a thousand shots is drawn: tests/browser/run BUILD tests/browser/paint.mjs [LOADS]
// First contentful paint as Chromium tells it, and the frame in which the first hundred shots are there; from navigation.
import { join } from 'node:path';
import { launch, open } from './harness/browser.mjs';
import { Rig, archive } from './harness/rig.mjs';
import { manyShots } from './harness/session.mjs';

const loads = Number(process.argv[2] ?? 10);

async function measured(browser, url) {
  const page = await open(browser, 'about:blank');
  await page.goto(`${url}#/history/thousand`, { waitUntil: 'commit' });
  await page.locator('main tbody tr').nth(99).waitFor();
  const times = await page.evaluate(() => new Promise((resolve) => requestAnimationFrame(() => setTimeout(() => resolve(
    { first: performance.getEntriesByName('first-contentful-paint')[0]?.startTime, shots: performance.now() })))));
  await page.context().close();
  return times;
}

const rig = await Rig.start(process.env.STROBE_BROWSER_FOLDER);
await rig.fire(1).end();
await rig.end();
await manyShots(rig.session, join(rig.sessions, 'thousand'), 1000);
const host = archive(rig.sessions);
const url = await host.address();
const browser = await launch();
const all = [];
for (let i = 0; i < loads; ++i) all.push(await measured(browser, url));
const words = (numbers) => {
  const sorted = numbers.sort((a, b) => a - b);
  return `median ${sorted[Math.floor(sorted.length / 2)].toFixed(0)}, largest ${sorted.at(-1).toFixed(0)} ms`;
};
console.log(`${loads} loads of a history of 1000 shots: first contentful paint ${words(all.map(({ first }) => first))}; ` +
  `first hundred shots ${words(all.map(({ shots }) => shots))}`);
await browser.close();
await host.kill();
