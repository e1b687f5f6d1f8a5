// Headless Chromium, and pages that are watched: whatever one says on its console, and whatever it asks for in vain, is kept.
import { existsSync } from 'node:fs';
import { mkdir } from 'node:fs/promises';
import { join } from 'node:path';
import { axeSource, build, chromium } from './packages.mjs';

const executable = ['/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome'].find(existsSync);

export function launch() {
  if (!executable) throw new Error('chromium is missing: tests/install-packages test');
  return chromium.launch({
    executablePath: executable,
    args: ['--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run', '--disable-background-networking',
      '--disable-component-update', '--disable-sync', '--disable-dev-shm-usage'],
  });
}

/// A page in a context of its own, as of another viewer. `trouble` lists what went wrong; `expect` takes patterns of what
/// the test itself causes, such as a server that is gone.
export async function open(browser, url, { size = { width: 1280, height: 800 }, dark = false, touch = false } = {}) {
  const context = await browser.newContext({ viewport: size, colorScheme: dark ? 'dark' : 'light', hasTouch: touch, reducedMotion: 'reduce' });
  const page = await context.newPage();
  page.setDefaultTimeout(120_000);
  page.trouble = [];
  page.requests = [];
  page.waiting = new Set();  // requests under way; the event stream always is
  page.on('console', (message) => {
    const isResponse = message.text().startsWith('Failed to load resource: the server responded');  // told below
    if (['error', 'warning'].includes(message.type()) && !isResponse) page.trouble.push(`console: ${message.text()} (${message.location().url})`);
  });
  page.on('pageerror', (error) => page.trouble.push(`script: ${error.stack ?? error.message}`));
  page.on('request', (request) => {
    page.requests.push(request.url());
    if (!request.url().endsWith('/events')) page.waiting.add(request);
  });
  page.on('requestfinished', (request) => page.waiting.delete(request));
  page.on('requestfailed', (request) => {
    page.waiting.delete(request);
    // A page that is left ends its event stream and what it still asked for.
    if (request.failure()?.errorText !== 'net::ERR_ABORTED') page.trouble.push(`failed: ${request.url()} ${request.failure()?.errorText}`);
  });
  page.on('response', (response) => {
    if (response.status() >= 400) page.trouble.push(`${response.status()}: ${response.url()}`);
  });
  await page.goto(url.toString(), { waitUntil: 'domcontentloaded' });
  return page;
}

export async function screenshot(page, name) {
  const folder = join(build, 'browser', 'screenshots');
  await mkdir(folder, { recursive: true });
  await page.screenshot({ path: join(folder, `${name}.png`), fullPage: true });
}

/// What axe finds serious or critical, each with where it is. The page's policy forbids foreign scripts; the debugger's
/// evaluation is none.
export async function accessibility(page, { frames = true } = {}) {
  for (const frame of frames ? page.frames() : [page.mainFrame()]) await frame.evaluate(axeSource);
  const { violations } = await page.evaluate((iframes) => window.axe.run(document, { resultTypes: ['violations'], iframes }), frames);
  return violations
    .filter((each) => ['serious', 'critical'].includes(each.impact))
    .flatMap((each) => each.nodes.map((node) => `${each.impact} ${each.id}: ${each.help}: ${node.target.join(' ')}: ${node.failureSummary?.replaceAll('\n', ' ')}`));
}
