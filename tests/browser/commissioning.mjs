// Commissioning with the page: what only watches inputs is confirmed there, what moves outputs is not.
import assert from 'node:assert/strict';
import { accessibility, screenshot } from './harness/browser.mjs';
import { check, keep, leave, rig, view } from './harness/lab.mjs';
import { until } from './harness/programs.mjs';

export function commissioning() {
  check('the key is proved by confirmations on the page; what moves outputs is asked at the console', async () => {
    const bench = await rig();
    const host = keep(bench.commission(['firmware', 'key', 'lamp_a']));
    const page = await view(await host.address());
    const confirm = page.getByRole('button', { name: 'Confirm' });
    const step = (title) => page.locator('.steps li').filter({ hasText: title });
    await confirm.click();
    await step('firmware').filter({ hasText: 'passed' }).waitFor();
    await confirm.click();
    let turned;
    await until(async () => {
      const asked = [...host.err.matchAll(/(?:have|turn) the key (on|off)/g)].at(-1)?.[1];
      if (asked && asked !== turned) await bench.drive(`KEY=${asked === 'on' ? 1 : 0}`);
      turned = asked;
      return (await step('key turned').filter({ hasText: /passed|FAILED/ }).count()) > 0;
    }, 'the verdict on the key');
    assert.equal(await step('key turned').filter({ hasText: 'passed' }).count(), 1);

    await page.getByText('Answer at the console').waitFor();
    assert.equal(await confirm.count(), 0);
    assert.deepEqual(await accessibility(page), []);
    await screenshot(page, 'commission-asked');
    assert.deepEqual(host.lines().map(({ step: name, state }) => [name, state]), [['firmware', 'passed'], ['key', 'passed']]);
    await leave(page);
    await host.kill('SIGINT');
    await bench.drive('KEY=1');
  });
}
