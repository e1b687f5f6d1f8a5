// Every view in every state, width and theme, to be looked at: tests/browser/run BUILD tests/browser/looks.mjs OUT [STATE...]
// OUT gets a picture of each and sheets of a state, a theme and a width; what harness/layout.mjs finds is printed.
import { cp, mkdir, writeFile } from 'node:fs/promises';
import { basename, join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';
import { launch, open } from './harness/browser.mjs';
import { json } from './harness/http.mjs';
import { endanger, layoutFaults, widths } from './harness/layout.mjs';
import { until } from './harness/programs.mjs';
import { goto, settled } from './harness/reading.mjs';
import { Rig, archive } from './harness/rig.mjs';
import { manyShots } from './harness/session.mjs';

const [out, ...wanted] = process.argv.slice(2);
const heights = { 360: 740, 768: 1024, 1280: 800, 1920: 1080 };
const columns = { 360: 4, 768: 3, 1280: 2, 1920: 2 };
const danger = 'THE OUTPUTS MAY BE ACTIVE: strobed was killed (signal 9), and line 17 of /dev/gpiochip0 cannot be had: Device or resource busy';

const rig = await Rig.start(process.env.STROBE_BROWSER_FOLDER);
const fired = async (shots, ...notes) => {
  await rig.fire(shots, { more: ['--spin', 'zero', '--angle', '23', ...notes.flatMap((note) => ['--note', note])] }).end();
};
await fired(1);
const folders = { empty: join(rig.folder, 'empty'), one: join(rig.folder, 'one') };
await mkdir(folders.empty);
await cp(rig.session, join(folders.one, 'today'), { recursive: true });
await manyShots(rig.session, join(rig.sessions, 'thousand'), 1000);
await cp(rig.session, join(rig.sessions, 'yesterday'), { recursive: true });
await fired(4, 'surface_name=acrylic', 'ball_name=ITF type 2');
await fired(4, 'surface_name=cushion', 'ball_name=ITF type 2');

/// The session of a thousand has no logs, of which the host makes a series: its points are those of its table.
async function drawThousand(page, url) {
  const { shots } = await json(url, '/api/v1/sessions/thousand/shots?limit=1000');
  const series = await json(url, '/api/v1/sessions/yesterday/series');
  await page.route('**/sessions/thousand/series*', (route) => route.fulfill({ json: { ...series, points: shots.reverse() } }));
}

const views = (session, shot) => [['shot', session, shot], ['series', session], ['history'], ['history', session], ['compare', { first: session, second: session, ...(shot > 1 && { first_like: '3', second_like: '7' }) }],
  ['timing'], ['commission'], ['report', session], ['shot', session, shot, 'afar']];
const states = {
  shots: { views: views('today', '5') },
  danger: { views: views('today', '5'), prepare: (page) => endanger(page, danger) },
  thousand: { prepare: drawThousand, views: [['series', 'thousand'], ['history', 'thousand'], ['history']] },
  one: { sessions: folders.one, views: views('today', '1') },
  empty: { sessions: folders.empty, views: [['shot'], ['series'], ['history'], ['compare'], ['timing'], ['commission'], ['report']] },
  gone: { views: views('today', '5'), ends: true },
};

async function look(page, parts, name) {
  const isAfar = parts.at(-1) === 'afar';
  await goto(page, ...(isAfar ? parts.slice(0, -1) : parts));
  await settled(page).catch(() => {});
  const button = page.locator('.afar-button');
  if (isAfar) await button.click();
  await page.waitForTimeout(150);
  const path = join(out, `${name}.png`);
  const height = Math.min(await page.evaluate(() => document.documentElement.scrollHeight), 2 * page.viewportSize().height);
  await page.screenshot({ path, fullPage: true, clip: { x: 0, y: 0, width: page.viewportSize().width, height } });
  for (const fault of await layoutFaults(page)) console.log(`${name}: ${fault}`);
  if (isAfar) await button.click();
  return path;
}

async function sheet(browser, pictures, count, name) {
  const style = `body{margin:8px;display:grid;gap:8px;align-items:start;background:#888;grid-template-columns:repeat(${count},1fr)}img{width:100%}`;
  const file = join(out, `sheet-${name}.html`);
  await writeFile(file, `<style>${style}</style>${pictures.map((picture) => `<img src="${basename(picture)}">`).join('')}`);
  const page = await browser.newPage({ viewport: { width: 1560, height: 400 } });
  await page.goto(pathToFileURL(resolve(file)).toString());
  await page.screenshot({ path: join(out, `sheet-${name}.png`), fullPage: true });
  await page.close();
}

await mkdir(out, { recursive: true });
const browser = await launch();
for (const [state, { sessions, views, prepare, ends }] of Object.entries(states)) {
  if (wanted.length > 0 && !wanted.includes(state)) continue;
  const host = sessions ? archive(sessions) : rig.live();
  const url = await host.address();
  const pages = {};
  for (const theme of ['light', 'dark']) {
    pages[theme] = await open(browser, url, { dark: theme === 'dark' });
    await prepare?.(pages[theme], url);
    await settled(pages[theme]);
  }
  if (ends) await host.kill();
  if (ends) await until(() => pages.dark.getByRole('alert').isVisible(), 'the loss');
  for (const [theme, page] of Object.entries(pages)) {
    for (const width of widths) {
      await page.setViewportSize({ width, height: heights[width] });
      const pictures = [];
      for (const parts of views) pictures.push(await look(page, parts, `${state}-${theme}-${width}-${parts.filter((part) => typeof part === 'string').join('-')}`));
      await sheet(browser, pictures, columns[width], `${state}-${theme}-${width}`);
    }
    await page.context().close();
  }
  await host.kill();
}
await browser.close();
await rig.end();
