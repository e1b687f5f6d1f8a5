// Sessions that were fired before: many shots, strange names, every view in both themes and on a narrow screen.
import assert from 'node:assert/strict';
import { accessibility, screenshot } from './harness/browser.mjs';
import { check, leave, markup, served, view } from './harness/lab.mjs';
import { endanger, layoutFaults, widths } from './harness/layout.mjs';
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

  check('a danger stands on top once, with its words whole, whatever the width', async () => {
    const words = 'THE OUTPUTS MAY BE ACTIVE: press the e-stop, and cut the power of lamps and machine: the worker died of signal 9 (Killed); /dev/gpiochip0: Device or resource busy';
    const watched = await view((await served()).url);
    await endanger(watched, words);
    await settled(watched);
    assert.equal(await watched.getByRole('alert').locator('p').innerText(), `Danger: ${words}`);
    assert.match(await watched.title(), /^DANGER/);
    for (const width of widths) {
      await watched.setViewportSize({ width, height: 800 });
      assert.deepEqual(await layoutFaults(watched), [], `${width} pixels wide`);
    }
    assert.deepEqual(await accessibility(watched), []);
    await leave(watched);
  });

  check('shots on two surfaces are neither pooled nor compared without their names', async () => {
    const text = async () => {
      await settled(page);
      return page.locator('main').innerText();
    };
    await goto(page, 'history', 'surfaces');
    assert.match(await text(), /cushion[^]*acrylic/);
    await goto(page, 'series', 'surfaces');
    assert.match(await text(), /The shots differ in surface\./);
    assert.equal(await page.locator('.run-chart').count(), 0);
    await page.getByRole('link', { name: 'acrylic' }).click();
    await page.getByRole('heading', { name: /^Series zero 23°, acrylic/ }).waitFor();
    assert.match(await text(), /2 shots counted/);
    await goto(page, 'compare', { first: 'surfaces', second: 'surfaces' });
    const conditions = page.getByLabel('Which shots of surfaces');
    for (const [left, surface] of [[2, /acrylic/], [1, /cushion/]]) {
      await until(async () => (await conditions.count()) === left, 'the choice of a condition');
      const option = await conditions.first().locator('option').filter({ hasText: surface }).getAttribute('value');
      await conditions.first().selectOption(option);
    }
    await page.getByText(/surfaces \(zero 23°, acrylic[^)]*\) less surfaces \(zero 23°, cushion[^)]*\)/).first().waitFor();
    assert.match(await text(), /The two differ in surface\./);
  });

  check('from afar four numbers are read, to one digit of their sd; others are chosen, and kept', async () => {
    const { shot } = await served();
    await goto(page, 'shot', 'today', shot);
    await settled(page);
    const toggle = page.getByRole('button', { name: 'Read from afar' });
    await toggle.click();
    const numbers = () => page.locator('.afar-numbers > div').evaluateAll((all) => all.map((each) => [each.querySelector('dt').textContent, each.querySelector('dd').textContent]));
    const four = await numbers();
    assert.equal(four.length, 4);
    for (const [label, number] of four) assert.match(number, /^\u2212?\d+(\.\d+)? ± (0?\.0*[1-9]0?|0\.0*[1-9]0?|\d+)$/, label);
    await page.getByText('Which numbers').click();
    await page.getByRole('checkbox', { name: 'dwell time' }).check();
    await page.getByRole('checkbox', { name: 'impulse ratio mu' }).uncheck();
    await page.reload();
    await settled(page);
    await toggle.click();
    const chosen = (await numbers()).map(([label]) => label);
    assert.equal(chosen.length, 4);
    assert.ok(chosen.some((label) => label.startsWith('dwell time')) && !chosen.includes('impulse ratio mu'), chosen.join());
    for (const width of widths) {
      await page.setViewportSize({ width, height: 800 });
      assert.deepEqual(await layoutFaults(page), [], `${width} pixels wide`);
    }
    assert.deepEqual(await accessibility(page), []);
    await page.setViewportSize({ width: 1280, height: 800 });
    await toggle.click();
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
      for (const width of [...widths].reverse()) {
        await page.setViewportSize({ width, height: 800 });
        let faults;
        // Charts follow the width a frame or two later.
        await until(async () => (faults = await layoutFaults(page)).length === 0, 'its layout', 5000).catch(() => {});
        assert.deepEqual(faults, [], `${width} pixels wide`);
      }
      await screenshot(page, `${name}-narrow`);
      await page.setViewportSize({ width: 1280, height: 800 });
      const controls = await page.locator('button, a, input, [role=button]').evaluateAll((all) => all.map((each) => each.ariaLabel || each.textContent || each.value || ''));
      assert.deepEqual(controls.filter((words) => /\b(fire|shoot|arm|trigger)\b/i.test(words)), []);
    }, { expected: /404: .*\/commission$/ });
  }
}
