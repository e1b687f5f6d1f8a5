// The page as the READMEs show it: a shot of a series, while the next ones are fired.
//   tests/browser/run BUILD tests/browser/picture.mjs host/web/gallery/page.jpg
import { launch, open } from './harness/browser.mjs';
import { until } from './harness/programs.mjs';
import { Rig } from './harness/rig.mjs';
import { settled, shownShot } from './harness/reading.mjs';

const rig = await Rig.start(process.env.STROBE_BROWSER_FOLDER);
const host = rig.fire(20, { more: ['--spin', 'zero', '--angle', '23'] });
const browser = await launch();
const page = await open(browser, await host.address(), { size: { width: 1360, height: 880 } });
await until(async () => {
  const shot = await shownShot(page);
  if (!(Number(shot?.name) >= 5)) return false;
  await settled(page);
  return (await page.locator('.verdict li').count()) === 0 && (await page.locator('main h1').textContent()).endsWith(shot.name);
}, 'a shot without a flag');
await page.screenshot({ path: process.argv[2], type: 'jpeg', quality: 66 });
await browser.close();
await host.kill();
await rig.end();
