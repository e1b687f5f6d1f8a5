// The page that annotates, by mouse and keys, and that what it saves is what the scorer reads.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { copyFileSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { accessibility, launch, open, screenshot } from '../browser/harness/browser.mjs';
import { build } from '../browser/harness/packages.mjs';

const here = fileURLToPath(new URL('.', import.meta.url));
const page = new URL('annotate.html', import.meta.url);
const picture = join(here, 'example', 'independent.jpg');
let browser, tab;

before(async () => {
  browser = await launch();
  tab = await open(browser, page);
  await tab.setInputFiles('#pictures', picture);
  await tab.waitForFunction(() => document.querySelector('#file').value === 'independent.jpg');
});
after(() => browser.close());

/// Where a place of the photograph is on the screen.
async function at([x, y]) {
  const canvas = tab.locator('canvas');
  const box = await canvas.boundingBox();
  const view = await canvas.evaluate(({ dataset }) => [dataset.zoom, dataset.x, dataset.y]);
  const [zoom, left, top] = view.map(Number);
  return { x: box.x + (x + 0.5) * zoom + left, y: box.y + (y + 0.5) * zoom + top, zoom };
}

async function drag(from, to, button = 'left') {
  const [a, b] = [await at(from), await at(to)];
  await tab.mouse.move(a.x, a.y);
  await tab.mouse.down({ button });
  await tab.mouse.move((a.x + b.x) / 2, (a.y + b.y) / 2);
  await tab.mouse.move(b.x, b.y);
  await tab.mouse.up({ button });
}

async function click(place) {
  const { x, y } = await at(place);
  await tab.mouse.click(x, y);
}

async function saved() {
  const [download] = await Promise.all([tab.waitForEvent('download'), tab.click('#save')]);
  return JSON.parse(readFileSync(await download.path(), 'utf8'));
}

/// A circle as drawn: to a pixel of the screen, and to the file's tenth.
async function assertCircle(circle, [x, y, d], kind) {
  const { zoom } = await at([0, 0]);
  for (const [value, wanted] of [[circle.x, x], [circle.y, y], [circle.d, d]])
    assert.ok(Math.abs(value - wanted) <= 2 / zoom + 0.1, `${JSON.stringify(circle)}: ${[x, y, d]}`);
  assert.equal(circle.kind, kind);
}

test('circles are drawn, moved, resized, given a kind, removed, and all that undone', async () => {
  await drag([200, 200], [260, 200]);
  await drag([500, 300], [500, 340]);
  await tab.keyboard.press('2');
  await drag([510, 300], [530, 310]);  // inside: moves
  await drag([560, 310], [570, 310]);  // its right handle: that side alone
  await tab.fill('#ball_diameter_m', '0.066');
  await tab.press('#ball_diameter_m', 'Enter');
  await tab.click('#scale');
  const [entry] = await saved();
  assert.equal(entry.file, 'independent.jpg');
  await assertCircle(entry.balls[0], [200, 200, 120], 'ball');
  await assertCircle(entry.balls[1], [525, 310, 90], 'optional');
  assert.ok(Math.abs(entry.px_per_m - entry.balls[0].d / 0.066) < 0.1);

  await tab.focus('canvas');
  await click([525, 310]);
  await tab.keyboard.press('Delete');
  assert.equal((await saved())[0].balls.length, 1);
  await tab.click('#undo');
  assert.equal((await saved())[0].balls.length, 2);
  await tab.click('#redo');
  assert.equal((await saved())[0].balls.length, 1);
  await tab.click('#undo');
});

test('three points on a rim make the circle through them, zoomed in and panned', async () => {
  await tab.focus('canvas');
  const { x, y } = await at([300, 500]);
  await tab.mouse.move(x, y);
  await tab.mouse.wheel(0, -600);
  await drag([300, 500], [320, 490], 'right');
  await tab.keyboard.press('1');
  await tab.keyboard.press('t');
  for (const [ux, uy] of [[1, 0], [0.6, 0.8], [-0.6, 0.8]]) await click([300 + 50 * ux, 500 + 50 * uy]);
  await assertCircle((await saved())[0].balls[2], [300, 500, 100], 'ball');
  await tab.focus('canvas');
  await tab.keyboard.press('f');
});

test('a ghost path, and the second annotation apart from the first', async () => {
  await tab.focus('canvas');
  await tab.keyboard.press('g');
  for (const corner of [[100, 600], [300, 620], [500, 650], [500, 650]]) await click(corner);
  await tab.keyboard.press('Enter');
  await tab.check('#second');
  await tab.fill('#annotator', 'B');
  await tab.press('#annotator', 'Enter');
  await drag([200, 202], [260, 202]);
  const [entry] = await saved();
  assert.equal(entry.ghost_path.length, 3);
  assert.equal(entry.balls.length, 3);
  assert.equal(entry.second.annotator, 'B');
  await assertCircle(entry.second.balls[0], [200, 202, 120], 'ball');
  await tab.uncheck('#second');
});

test('the scorer reads what the page saves, and the page what it saved', async (t) => {
  const folder = mkdtempSync(join(tmpdir(), 'strobe-annotate-'));
  t.after(() => rmSync(folder, { recursive: true }));
  const truth = await saved();
  writeFileSync(join(folder, 'truth.json'), JSON.stringify(truth));
  copyFileSync(picture, join(folder, 'independent.jpg'));
  const words = [folder, '--as-is', '--scale-off', '0', '--json', '--program', "echo '[]'"];
  const program = join(build, 'bin', 'strobe-score');
  const { status, stdout, stderr } = spawnSync(program, words, { encoding: 'utf8' });
  assert.equal(status, 1, stderr);  // two balls are to be found, none is
  assert.equal(JSON.parse(stdout.split('\n')[0]).balls, 2);
  await tab.setInputFiles('#truth', join(folder, 'truth.json'));
  assert.deepEqual(await saved(), truth);
  writeFileSync(join(folder, 'truth.json'), '{"no": "list"}');
  await tab.setInputFiles('#truth', join(folder, 'truth.json'));
  const refused = () => document.querySelector('#status').textContent.startsWith('truth.json: it is no list');
  await tab.waitForFunction(refused);
  assert.deepEqual(await saved(), truth);
});

test('it is one file that asks for nothing, says what is missing, and is accessible', async () => {
  assert.deepEqual(tab.requests.filter((url) => !/^(file|blob):/.test(url)), []);
  assert.ok(!/(src|href)=/.test(readFileSync(page, 'utf8').replaceAll('link.href', '')));
  assert.deepEqual(await accessibility(tab), []);
  await screenshot(tab, 'annotate');
  await tab.fill('#px_per_m', '');
  await tab.press('#px_per_m', 'Enter');
  await tab.click('#save');
  assert.match(await tab.textContent('#status'), /px_per_m must be a number above 0/);
  assert.deepEqual(tab.trouble, []);
});
