// A series as it is fired: what is printed is what viewers see; they stop it, and nothing else.
import assert from 'node:assert/strict';
import { json } from './harness/http.mjs';
import { check, keep, leave, markup, rig, view } from './harness/lab.mjs';
import { until } from './harness/programs.mjs';
import { goto, shownShot, tab, tabTo } from './harness/reading.mjs';

const labels = ['--spin', 'zero', '--angle', '23', '--note', `operator=${markup}`];
const shots = 500;  // more than are fired until the series is stopped
const gone = /^503: |ERR_CONNECTION_REFUSED|ERR_INCOMPLETE_CHUNKED_ENCODING|ERR_EMPTY_RESPONSE|ERR_CONNECTION_RESET|ERR_NETWORK/;

/// Fails unless `shown` is `value`, rounded at its last digit.
function assertRounded(shown, value, what) {
  const text = shown.replace('\u2212', '-').replace('±', '').trim();
  const decimals = text.split('.')[1]?.length ?? 0;
  assert.match(text, /^-?\d+(\.\d+)?$/, what);
  assert.ok(Math.abs(Number(text) - value) <= 0.5000001 * 10 ** -decimals, `${what}: ${text} is not ${value}`);
}

function assertSame(shown, printed, quantities) {
  const essentials = quantities.filter((quantity) => quantity.essential && Number.isFinite(printed[quantity.name]));
  assert.ok(essentials.length >= 8);
  for (const { name, label } of essentials) {
    const what = `${label} of shot ${shown.name}`;
    assertRounded(shown.numbers[label].value, printed[name], what);
    assertRounded(shown.numbers[label].sd, Math.hypot(printed.sd[name], printed.sd_systematic[name]), `sd of ${what}`);
  }
}

export function series() {
  let host, url, first, second, quantities;
  const last = () => host.lines().at(-1);

  check('each shot comes to the page with the numbers that --json prints', async () => {
    host = keep((await rig()).fire(shots, { more: labels }));
    url = await host.address();
    first = await view(url);
    quantities = await json(url, '/api/v1/quantities');
    const compared = new Set();
    await until(async () => {
      const shown = await shownShot(first);
      const printed = shown && host.lines().find((line) => `${line.shot_id}` === shown.name);
      if (printed && !compared.has(shown.name) && !printed.rejected) {
        assertSame(shown, printed, quantities);
        compared.add(shown.name);
      }
      return compared.size >= 3;
    }, 'three shots on the page');
    const details = first.requests.filter((address) => new RegExp(`/shots/${[...compared][1]}$`).test(address));
    assert.ok(details.length >= 1 && details.length <= 3, `${details.length} times asked for one shot's details`);
  });

  check('a page that is loaded anew in mid-series shows all that was fired, and what comes', async () => {
    await first.reload();
    const before = host.lines().length;
    await until(async () => Number((await shownShot(first))?.name) > before, 'a further shot');
    await goto(first, 'history', 'today');
    await until(async () => (await first.locator('main tbody tr').count()) >= before, 'all shots in the history');
  });

  check('a second viewer sees the same', async () => {
    second = await view(url, { size: { width: 1024, height: 768 }, dark: true, touch: true });
    await tab(first, 'shot');
    await until(async () => {
      const [one, other] = [await shownShot(first), await shownShot(second)];
      if (!one || one.name !== other?.name) return false;
      // The series' mean may be a shot ahead on one of them: it is not compared.
      assert.deepEqual(one.numbers, other.numbers);
      return true;
    }, 'the same shot on both');
  });

  check('by keyboard alone a shot is opened and the series stopped', async () => {
    await first.bringToFront();
    await tabTo(first, '#tabs a', /^History$/);
    await first.keyboard.press('Enter');
    await first.getByRole('heading', { name: 'History' }).waitFor();
    await tabTo(first, 'main tbody a', /^today$/);
    await first.keyboard.press('Enter');
    await first.getByRole('heading', { name: 'Shots of today' }).waitFor();
    const opened = await tabTo(first, 'main tbody th a');
    await first.keyboard.press('Enter');
    await until(async () => (await shownShot(first))?.name === opened, `shot ${opened}, opened by keyboard`);
    await first.evaluate(() => (window.loadedOnce = true));
    await tabTo(first, 'button', /stop/i);
    const begun = host.lines().length;
    await first.keyboard.press('Enter');
    assert.deepEqual(await host.end(), { code: 1, signal: null }, host.err);
    assert.match(host.err, /--resume/);
    assert.ok(host.lines().length >= begun && host.lines().length <= begun + 2, 'the shot under way is finished, and none begun');
  }, { expected: gone });

  check('a page whose host is gone says so, and goes on with the next one, without being loaded anew', async () => {
    for (const page of [first, second]) await page.getByRole('alert').filter({ hasText: /not connected/i }).waitFor();
    host = keep((await rig()).fire(shots, { address: url.host, more: labels }));
    await host.address();
    for (const page of [first, second]) {
      await goto(page, 'shot');
      await page.getByRole('alert').filter({ hasText: /not connected/i }).waitFor({ state: 'hidden' });
      await until(async () => last() && (await shownShot(page))?.name === `${last().shot_id}`, 'the new series');
    }
    assert.equal(await first.evaluate(() => window.loadedOnce), true);
  }, { expected: gone });

  check('disarming from the page ends the series at once', async () => {
    await second.getByRole('button', { name: /disarm/i }).click();
    const { code } = await host.end();
    assert.equal(code, 1, host.err);
    for (const page of [first, second]) await leave(page);
  }, { expected: gone });
}
