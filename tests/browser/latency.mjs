// How long after its readout a shot is on the page, and what viewers cost the host:
//   tests/browser/run BUILD tests/browser/latency.mjs [SHOTS [VIEWERS]]
// From the line that --json prints to the frame in which Chromium has drawn the shot, by one wall clock; from the photograph's
// end to that line; flashes issued after their commanded instants. With viewers, in turns of five shots with and without.
import { readFileSync, statSync } from 'node:fs';
import { join } from 'node:path';
import { launch, open } from './harness/browser.mjs';
import { until } from './harness/programs.mjs';
import { Rig } from './harness/rig.mjs';
import { Viewers } from './harness/viewers.mjs';

const [shots = 50, viewers = 0] = process.argv.slice(2).map(Number);
const turn = 5;

/// Notes in the page when each shot is first drawn: its heading and numbers are there, and the frame after that has been made.
function watch() {
  window.drawn = {};
  const look = () => {
    const name = document.querySelector('main h1')?.textContent.match(/^Shot (\S+)/)?.[1];
    if (!name || window.drawn[name] !== undefined || !document.querySelector('table.essentials')) return;
    window.drawn[name] = null;
    requestAnimationFrame(() => setTimeout(() => (window.drawn[name] = performance.timeOrigin + performance.now())));
  };
  new MutationObserver(look).observe(document.querySelector('main'), { childList: true, subtree: true, characterData: true });
}

function figures(numbers, unit, decimals) {
  const sorted = numbers.sort((a, b) => a - b);
  const quantile = (part) => sorted[Math.max(0, Math.ceil(part * sorted.length) - 1)]?.toFixed(decimals);
  return `p50 ${quantile(0.5)}, p99 ${quantile(0.99)}, largest ${quantile(1)} ${unit} (n ${sorted.length})`;
}

const rig = await Rig.start(process.env.STROBE_BROWSER_FOLDER);
const host = rig.fire(shots, { machineTime: true });
const url = await host.address();
const browser = await launch();
const page = await open(browser, url);
await page.waitForSelector('main h1');
await page.evaluate(watch);
const watched = [];  // of each shot: whether viewers were there
let crowd;
let drawn = {};
await until(async () => {
  const begun = host.lines().length;
  const wanted = viewers > 0 && Math.floor(begun / turn) % 2 === 1;
  if (wanted && !crowd) crowd = new Viewers(url, viewers);
  if (!wanted && crowd) crowd = crowd.leave();
  watched[begun] = wanted;
  drawn = { ...drawn, ...(await page.evaluate(() => window.drawn).catch(() => ({}))) };
  return host.status;
}, 'the series', shots * 60_000);

const flashes = readFileSync(join(rig.session, 'flashes.csv'), 'utf8').trim().split('\n').map((row) => row.split(','));
const column = (name) => flashes[0].indexOf(name);
const latenessOf = (shot) => flashes.slice(1).filter((row) => Number(row[column('shot_id')]) === shot)
  .map((row) => (Number(row[column('issue_start_ns')]) - Number(row[column('commanded_ns')])) / 1000);
const photographEnd = (shot) => statSync(join(rig.folder, 'camera', `exposure-${`${shot}`.padStart(4, '0')}.tif`)).mtimeMs;

const printed = host.timedLines().map(({ line, at }, i) => ({ shot: line.shot_id, at, watched: watched[i] }));
for (const with_viewers of viewers > 0 ? [false, true] : [false]) {
  const ours = printed.filter((each) => each.watched === with_viewers);
  console.log(with_viewers ? `with ${viewers} viewers:` : 'without further viewers:');
  console.log(`  printed readout to drawn shot: ${figures(ours.filter(({ shot }) => drawn[shot]).map(({ shot, at }) => drawn[shot] - at), 'ms', 1)}`);
  console.log(`  end of photograph to printed readout: ${figures(ours.map(({ shot, at }) => at - photographEnd(shot)), 'ms', 0)}`);
  console.log(`  flashes after their instants: ${figures(ours.flatMap(({ shot }) => latenessOf(shot)), 'us', 2)}`);
}
await browser.close();
await rig.end();
