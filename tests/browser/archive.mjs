// Sessions that were fired before: many shots, strange names, every view in both themes and on a narrow screen.
import assert from 'node:assert/strict';
import { accessibility, screenshot } from './harness/browser.mjs';
import { check, markup, served, view } from './harness/lab.mjs';
import { until } from './harness/programs.mjs';
import { goto, settled } from './harness/reading.mjs';

export function archive() {
  let page;

  check('the history of a thousand shots costs few requests, and shows each once', async () => {
    page = await view((await served()).url);
    await settled(page);
    page.requests.length = 0;
    await goto(page, 'history', 'thousand');
    await page.locator('main tbody tr').first().waitFor();
    const nodes = await page.evaluate(() => document.querySelectorAll('*').length);
    assert.ok(nodes < 8000, `${nodes} elements at first`);
    assert.ok(page.requests.length <= 6, page.requests.join('\n'));
    const rows = page.locator('main tbody tr');
    await until(async () => {
      await page.evaluate(() => scrollTo(0, document.body.scrollHeight));
      return (await rows.count()) >= 1000;
    }, 'the oldest shots');
    const names = await page.locator('main tbody tr th').allTextContents();
    assert.equal(names.length, 1000);
    assert.equal(new Set(names).size, 1000);
  });

  check('names with markup are text, wherever they are shown', async () => {
    await goto(page, 'history');
    await settled(page);
    assert.ok((await page.locator('main').innerText()).includes(markup));
    for (const parts of [['shot', markup, '1'], ['series', markup], ['history', markup], ['report', markup], ['compare', { first: markup, second: 'today' }]]) {
      await goto(page, ...parts);
      await settled(page);
      for (const frame of page.frames()) assert.equal(await frame.locator('img[src="x"]').count(), 0, parts[0]);
    }
  });

  // Each view as an operator finds it: what is on it is reached without a mouse, read by a screen reader, and fits a telephone.
  const views = [['shot', 'today'], ['series', 'today'], ['history', 'today'], ['history'], ['compare', { first: 'today', second: markup }], ['timing'], ['commission'], ['report', 'today']];
  for (const parts of views) {
    const name = [parts[0], ...(parts.length === 1 && parts[0] === 'history' ? ['all'] : [])].join('-');
    check(`${parts.filter((part) => typeof part === 'string').join('/')} is accessible, dark and light, fits a narrow screen, and has nothing that fires`, async () => {
      for (const theme of ['dark', 'light']) {
        await page.emulateMedia({ colorScheme: theme });
        await goto(page, ...parts, ...(parts[0] === 'shot' ? [(await served()).shot] : []));
        await settled(page);
        // The report in its frame has one theme, and is long.
        assert.deepEqual(await accessibility(page, { frames: theme === 'light' }), [], theme);
        await screenshot(page, `${name}-${theme}`);
      }
      await page.setViewportSize({ width: 360, height: 740 });
      let width;
      await until(async () => (width = await page.evaluate(() => document.scrollingElement.scrollWidth)) <= 360, 'charts of the new width', 10_000).catch(() => {});
      await settled(page);
      await screenshot(page, `${name}-narrow`);
      await page.setViewportSize({ width: 1280, height: 800 });
      assert.ok(width <= 360, `${width} pixels wide`);
      const controls = await page.locator('button, a, input, [role=button]').evaluateAll((all) => all.map((each) => each.ariaLabel || each.textContent || each.value || ''));
      assert.deepEqual(controls.filter((words) => /\b(fire|shoot|arm|trigger)\b/i.test(words)), []);
    }, { expected: /404: .*\/commission$/ });
  }
}
