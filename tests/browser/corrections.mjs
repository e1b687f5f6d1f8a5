// Corrections by hand on the photograph: seen before they are saved, saved as `strobe shot --edit` saves them, taken back.
import assert from 'node:assert/strict';
import { cp, readFile, readdir, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { screenshot } from './harness/browser.mjs';
import { check, folder, served, view } from './harness/lab.mjs';
import { program, run, until } from './harness/programs.mjs';
import { goto, settled, shownShot } from './harness/reading.mjs';

/// {name: text} of what a session keeps of its corrections, without the time of their making in names and texts.
async function kept(session) {
  const names = (await readdir(join(session, 'digitizations')).catch(() => [])).sort();
  const timeless = (text) => text.replace(/\d{4}-?\d\d-?\d\dT\d\d:?\d\d:?\d\d(\.\d+)?Z/g, 'TIME');
  const entries = names.map(async (name) => [timeless(name), timeless(await readFile(join(session, 'digitizations', name), 'latin1'))]);
  return Object.fromEntries(await Promise.all(entries));
}

export function corrections() {
  check('an image is moved by keyboard: the readout changes, it is saved as --edit saves it, and taken back', async () => {
    const { url, session, shot } = await served();
    const copy = join(folder, 'copy');
    await cp(session, copy, { recursive: true });
    const page = await view(url);
    const sent = [];
    page.on('request', (request) => request.url().endsWith('/corrections') && request.method() === 'POST' && sent.push(request.postDataJSON().corrections));
    await goto(page, 'shot', 'today', shot);
    await settled(page);
    const before = await until(() => shownShot(page), 'its numbers');

    await page.getByRole('button', { name: /^Correct/ }).click();
    const image = page.locator('[data-key^="found-"]').nth(4);
    await image.focus();
    await page.keyboard.press('Enter');
    for (let i = 0; i < 3; ++i) await page.keyboard.press('Shift+ArrowRight');
    await page.getByRole('table', { name: /before and after/ }).locator('tbody tr').first().waitFor();
    await screenshot(page, 'corrections');
    assert.deepEqual(await kept(session), {}, 'nothing is written before it is saved');

    await page.getByRole('button', { name: /^Save/ }).click();
    await until(async () => JSON.stringify((await shownShot(page))?.numbers) !== JSON.stringify(before.numbers), 'the corrected numbers');
    assert.equal(sent.length, 1);
    await writeFile(join(folder, 'corrections.toml'), sent[0]);
    await run(program('strobe'), ['shot', copy, shot, '--edit', join(folder, 'corrections.toml')]);
    assert.ok(Object.keys(await kept(copy)).length > 0);
    assert.deepEqual(await kept(session), await kept(copy));

    await page.getByRole('button', { name: /^Undo the newest/ }).click();
    await until(async () => JSON.stringify((await shownShot(page))?.numbers) === JSON.stringify(before.numbers), 'the first numbers again');
  });
}
