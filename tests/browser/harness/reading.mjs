// What a page shows, read as a person does: headings, tables, tabs.
import { until } from './programs.mjs';

/// Follows a tab: "shot", "series", "history" …
export async function tab(page, name) {
  await page.click(`#tabs a[data-view="${name}"]`);
}

/// Opens a view by the address behind the page's #, whose last part may be an object: the query.
export async function goto(page, ...parts) {
  const query = typeof parts.at(-1) === 'object' ? `?${new URLSearchParams(parts.pop())}` : '';
  await page.evaluate((hash) => (location.hash = hash), `#/${parts.map(encodeURIComponent).join('/')}${query}`);
}

/// {name, numbers: {label: {value, sd}}} of the shot on the page, at one instant; null while there is none.
export function shownShot(page) {
  return page.evaluate(() => {
    const name = document.querySelector('main h1')?.textContent.match(/^Shot (\S+)/)?.[1];
    const rows = [...document.querySelectorAll('table.essentials tbody tr')];
    if (name === undefined || rows.length === 0) return null;
    const cells = (row) => [...row.querySelectorAll('td')].map((cell) => cell.textContent.trim());
    return { name, numbers: Object.fromEntries(rows.map((row) => [row.querySelector('th').textContent, { value: cells(row)[0], sd: cells(row)[1] }])) };
  });
}

/// Once it has what it asked for, and nothing on it says that something is still on its way.
export async function settled(page) {
  const shown = () => page.evaluate(() => new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(() => {
    const main = document.querySelector('main');
    const within = [...document.querySelectorAll('iframe')].map((frame) => frame.contentDocument?.body?.innerText ?? '').join();
    resolve(main.querySelector('h1') && !/(Loading|Reading|Asking|Comparing|on its way|being written)/.test(main.innerText + within) && [...document.images].every((image) => image.complete));
  }))));
  await until(async () => page.waiting.size === 0 && (await shown()) && page.waiting.size === 0, `${page.url()} to be read`);
}

/// Presses Tab until what has the focus fits; returns its text. Every element on the way shows that it has the focus.
export async function tabTo(page, selector, words = /./) {
  for (let presses = 0; presses < 400; ++presses) {
    await page.keyboard.press('Tab');
    const found = await page.evaluate(([wanted, source]) => {
      const element = document.activeElement;
      const style = getComputedStyle(element);
      const seen = style.outlineStyle !== 'none' || style.boxShadow !== 'none' || element.tabIndex < 0;  // a heading is read, not used
      const text = (element.textContent || element.ariaLabel || '').trim();
      return { seen, text, fits: element.matches(wanted) && new RegExp(source).test(text) };
    }, [selector, words.source]);
    if (!found.seen) throw new Error(`nothing shows that "${found.text}" has the focus`);
    if (found.fits) return found.text;
  }
  throw new Error(`Tab never comes to ${selector} ${words}`);
}
