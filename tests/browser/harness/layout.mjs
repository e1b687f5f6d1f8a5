// What is wrong with how a page is laid out, as far as a machine can tell.

/// Runs in the page. A line for each: wider than the window; hidden sideways where nothing shows that it scrolls; a word that
/// falls apart into lines; texts on top of each other; a sentence that stands twice in the bar.
function faultsNow() {
  const faults = new Set();
  const name = (element) => `${element.tagName.toLowerCase()}.${element.getAttribute('class') ?? ''} "${element.textContent.trim().slice(0, 40)}"`;
  const width = document.documentElement.clientWidth;
  const scrolls = (element) => ['auto', 'scroll', 'hidden', 'clip'].includes(getComputedStyle(element).overflowX);
  const isClipped = (element) => element.parentElement && (scrolls(element.parentElement) || isClipped(element.parentElement));
  const isShown = (element) => element.checkVisibility() && !element.closest('.visually-hidden, .skip');
  for (const element of document.body.querySelectorAll('*')) {
    if (!isShown(element)) continue;
    const { left, right } = element.getBoundingClientRect();
    if ((right > width + 1 || left < -1) && !isClipped(element)) faults.add(`beyond the window: ${name(element)}`);
    const mayScroll = element.matches('.table-scroll:not(:has(.rows)), select, svg, svg *') || element.closest('.photograph-stage');
    if (scrolls(element) && element.scrollWidth > element.clientWidth + 1 && !mayScroll) faults.add(`hidden sideways: ${name(element)}`);
  }

  const texts = [];
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  for (let node = walker.nextNode(); node; node = walker.nextNode()) {
    const parent = node.parentElement;
    if (!node.data.trim() || !isShown(parent) || parent.closest('option')) continue;
    const range = document.createRange();
    for (const { 0: word, index } of node.data.matchAll(/[\p{L}\p{N}]{2,24}/gu)) {
      range.setStart(node, index);
      range.setEnd(node, index + word.length);
      if (new Set([...range.getClientRects()].map(({ top }) => Math.round(top))).size > 1) faults.add(`"${word}" falls apart: ${name(parent)}`);
    }
    range.selectNodeContents(node);
    // A line's height is more than its letters': what touches does not overlap.
    for (const { left, right, top, bottom } of range.getClientRects()) {
      const inset = 0.2 * (bottom - top);
      if (!parent.closest('.photograph-stage')) texts.push({ node, left: left + 1, right: right - 1, top: top + inset, bottom: bottom - inset });
    }
  }
  texts.sort((a, b) => a.top - b.top);
  texts.forEach((a, i) => {
    for (let k = i + 1; k < texts.length && texts[k].top < a.bottom; ++k) {
      const b = texts[k];
      const apart = a.right <= b.left || b.right <= a.left || a.node === b.node;
      const isCut = [a, b].some(({ node }) => node.parentElement.closest('.table-scroll'));
      if (!apart && !isCut) faults.add(`on top of each other: "${a.node.data}" and "${b.node.data}"`);
    }
  });

  const told = [...document.querySelectorAll('.bar p, .bar li, .bar dd')].filter((each) => isShown(each) && each.textContent.length > 24).map((each) => each.textContent);
  told.forEach((words, i) => {
    const gist = words.replace(/^[^:]*: /, '');
    if (told.some((other, k) => k !== i && other.includes(gist))) faults.add(`stands twice: "${gist}"`);
  });
  return [...faults];
}

/// The widths at which each view must be in order.
export const widths = [360, 768, 1280, 1920];

export async function layoutFaults(page) {
  await page.evaluate(() => scrollTo(0, 0));
  return page.evaluate(faultsNow);
}

/// What the page hears from its host has this sentence of danger from now on.
export async function endanger(page, danger) {
  const told = (status) => ({ ...status, danger, missing: danger });  // as a host tells it
  await page.route('**/api/v1/live', async (route) => {
    const answer = await route.fetch();
    const live = await answer.json();
    await route.fulfill({ response: answer, json: { ...live, status: told(live.status) } });
  });
  await page.addInitScript((words) => {
    const parse = JSON.parse;
    JSON.parse = (text) => {
      const value = parse(text);
      return value?.estop ? { ...value, danger: words, missing: words } : value;
    };
  }, danger);
  await page.reload();
}
