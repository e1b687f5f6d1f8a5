// The editor of corrections: each way to correct an image or the surface line makes the entry that it should, seen in the
// preview's text; what fails or is left is not lost; a finger does what a mouse does.
import assert from 'node:assert/strict';
import { accessibility, screenshot } from './harness/browser.mjs';
import { check, served, view } from './harness/lab.mjs';
import { until } from './harness/programs.mjs';
import { goto, settled } from './harness/reading.mjs';

const found = '[data-key^="found-"]';

/// The editor of one shot: {page, text}: text(wanted) is the newest text that a preview was asked of, once it fits (a pattern
/// or a function) and is answered. While something is dragged, each place on the way is asked.
async function correcting(options) {
  const { url, shot } = await served();
  const page = await view(url, options);
  const asked = [], answered = [];
  page.on('request', (request) => request.url().endsWith('/preview') && asked.push(request.postDataJSON().corrections));
  page.on('response', (response) => response.url().endsWith('/preview') && answered.push(response.status()));
  await goto(page, 'shot', 'today', shot);
  await settled(page);
  await page.getByRole('button', { name: /^Correct/ }).click();
  await page.locator(found).first().waitFor();
  await page.locator('.photograph-stage').evaluate((stage) => stage.scrollIntoView({ block: 'center' }));
  const text = async (wanted) => {
    const fits = wanted instanceof RegExp ? (text) => wanted.test(text) : wanted;
    await until(async () => fits(asked.at(-1) ?? '') && answered.length === asked.length, `a preview of ${wanted}`);
    return asked.at(-1);
  };
  return { page, text };
}

/// Where an image's middle is on the screen.
async function middleOf(page, position) {
  return page.locator(found).nth(position).evaluate((mark) => {
    const circle = mark.querySelector('circle').getBoundingClientRect();
    return { x: circle.x + circle.width / 2, y: circle.y + circle.height / 2 };
  });
}

async function handle(page, name) {
  const box = await page.locator(`.edit-handle.is-${name}`).first().boundingBox();
  return { x: box.x + box.width / 2, y: box.y + box.height / 2 };
}

async function drag(page, from, dx, dy) {
  await page.mouse.move(from.x, from.y);
  await page.mouse.down();
  await page.mouse.move(from.x + dx, from.y + dy, { steps: 5 });
  await page.mouse.up();
}

/// The number after `key = ` in the text, or the two of a point.
function numbersOf(text, key) {
  const line = text.split('\n').find((each) => each.startsWith(`${key} = `));
  assert.ok(line, `${key} in ${text}`);
  return line.match(/-?\d+(\.\d+)?/g).map(Number);
}

async function choose(page, position) {
  const at = await middleOf(page, position);
  await page.mouse.click(at.x, at.y);
  return at;
}

export function edits() {
  check('an image is dragged, its rim and its equator too, each a step that is taken back', async () => {
    const { page, text } = await correcting();
    const at = await choose(page, 3);
    await page.mouse.move(at.x, at.y);
    await page.mouse.down();
    await page.mouse.move(at.x + 30, at.y, { steps: 5 });
    const tried = await text(/centre_image_px/);
    await page.mouse.move(at.x + 12, at.y, { steps: 5 });
    await page.mouse.up();
    let asked = await text((newest) => newest !== tried);
    const [column, row] = numbersOf(asked, 'centre_image_px');
    const [foundColumn, foundRow] = numbersOf(asked, 'at_image_px');
    assert.ok(column > foundColumn && Math.abs(row - foundRow) < 0.01, asked);

    const shown = Number(await page.getByLabel('Diameter, px').inputValue());
    const rim = await handle(page, 'rim');
    await drag(page, rim, rim.x - (at.x + 12), rim.y - at.y);
    // To twice its radius, by a px or two of the screen.
    await text((newest) => /diameter_image_px/.test(newest) && Math.abs(numbersOf(newest, 'diameter_image_px')[0] / (2 * shown) - 1) < 0.05);

    const equator = await handle(page, 'equator');
    await drag(page, equator, 0, 15);
    asked = await text(/equator_image_deg/);
    await page.getByLabel('No equator is seen').check();
    asked = await text(/no_equator = true/);
    assert.deepEqual(await accessibility(page), []);
    assert.doesNotMatch(asked, /equator_image_deg/);

    for (let steps = 0; steps < 4; ++steps) await page.getByRole('button', { name: 'Undo step' }).click();
    assert.equal(await page.getByRole('button', { name: /^Save/ }).getAttribute('aria-disabled'), 'true', 'nothing is left to be saved');
    for (let steps = 0; steps < 4; ++steps) await page.keyboard.press('Control+y');
    assert.match(await text(/no_equator = true/), /diameter_image_px/);
    await page.getByRole('button', { name: /^Discard/ }).click();
  });

  check('an image is removed, one is added where it is clicked, the surface line is moved', async () => {
    const { page, text } = await correcting();
    await choose(page, 2);
    await page.getByRole('button', { name: /^Remove/ }).click();
    await text(/^\[\[remove\]\]\nat_image_px = /);
    const stage = await page.locator('.photograph-stage').boundingBox();
    await page.getByRole('button', { name: /^Add image/ }).click();
    await page.mouse.click(stage.x + stage.width / 2, stage.y + 30);
    const added = await text(/\[\[add\]\]\ncentre_image_px/);
    await page.keyboard.press('Shift+ArrowRight');
    const after = (whole) => numbersOf(whole.slice(whole.indexOf('[[add]]')), 'centre_image_px')[0];
    await text((newest) => newest.includes('[[add]]') && Math.abs(after(newest) - after(added) - 1) < 0.002);
    await page.keyboard.press('Delete');
    await page.getByRole('button', { name: /^Surface line/ }).click();
    await drag(page, await handle(page, 'surface'), 0, 6);
    const line = await text(/\[surface\]\nleft_image_px/);
    assert.doesNotMatch(line, /\[\[add\]\]/);
    assert.ok(numbersOf(line, 'left_image_px')[1] > 0 && numbersOf(line, 'right_image_px')[0] > numbersOf(line, 'left_image_px')[0]);
    await screenshot(page, 'corrections-surface');
    await page.getByRole('button', { name: /^Discard/ }).click();
  });

  check('what the host cannot use is told in its words, and stays to be put right', async () => {
    const { page, text } = await correcting();
    await choose(page, 3);
    // All but one: no flight is left to be measured. Each preview may give the others another order.
    const left = page.locator(`${found}:not(.is-removed)`);
    for (let count = await left.count(); count > 1; --count) {
      await left.first().focus();
      await page.keyboard.press('Enter');
      await page.keyboard.press('Delete');
      await until(async () => (await left.count()) === count - 1, 'one image less');
    }
    await text(/(\[\[remove\]\]\n[^\n]*\n\s*){3,}/);
    await page.locator('.edit-problem, .edit-verdict').filter({ hasText: /./ }).first().waitFor();
    await page.getByRole('button', { name: /^Discard/ }).click();
    assert.equal(await page.locator(`${found}.is-removed`).count(), 0);
  });

  check('a save that fails is told, and what is not saved outlives a reload', async () => {
    const { page, text } = await correcting();
    await choose(page, 4);
    await page.keyboard.press('Shift+ArrowLeft');
    const kept = await text(/centre_image_px/);
    await page.route('**/corrections', (route) =>
      (route.request().method() === 'POST' ? route.fulfill({ status: 500, json: { error: 'the disk is full' } }) : route.continue()));
    await page.getByRole('button', { name: /^Save/ }).click();
    await page.getByText('Not saved: the disk is full').waitFor();
    page.on('dialog', (dialog) => dialog.accept());
    const asked = [];
    page.on('request', (request) => request.url().endsWith('/preview') && asked.push(request.postDataJSON().corrections));
    await page.reload();
    await settled(page);
    await page.getByText(/not saved yet/).waitFor();
    await page.getByRole('button', { name: /^Correct/ }).click();
    await until(async () => asked.at(-1) === kept, 'the same corrections again');
    await page.getByRole('button', { name: /^Discard/ }).click();
    await page.getByRole('button', { name: /^Close/ }).click();
    await page.getByRole('button', { name: /^Correct/ }).waitFor();
  }, { expected: /500/ });

  check('a finger chooses an image and moves it', async () => {
    const { page, text } = await correcting({ size: { width: 820, height: 1180 }, touch: true, dark: true });
    const at = await middleOf(page, 3);
    await page.touchscreen.tap(at.x, at.y);
    await page.locator(`${found}.is-selected`).waitFor();
    const fingers = await page.context().newCDPSession(page);
    const touch = (type, points) => fingers.send('Input.dispatchTouchEvent', { type, touchPoints: points });
    await touch('touchStart', [at]);
    for (let step = 1; step <= 6; ++step) await touch('touchMove', [{ x: at.x + 5 * step, y: at.y }]);
    await touch('touchEnd', []);
    const asked = await text(/centre_image_px/);
    assert.ok(numbersOf(asked, 'centre_image_px')[0] > numbersOf(asked, 'at_image_px')[0]);
    assert.deepEqual(await accessibility(page), []);
    await screenshot(page, 'corrections-tablet');
    await page.getByRole('button', { name: /^Discard/ }).click();
  });
}
