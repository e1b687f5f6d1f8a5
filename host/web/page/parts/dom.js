// Elements made by script. Text is always set as text, so that markup in names is shown as it stands; style attributes are
// not made (the page's content security policy forbids them).

const SVG = "http://www.w3.org/2000/svg";

/// h("p", {class: "note", onclick: f, hidden: true}, "text", element, [more], null): null and false are left out.
export function h(tag, attributes = {}, ...children) {
  return filled(document.createElement(tag), attributes, children);
}

export function svg(tag, attributes = {}, ...children) {
  return filled(document.createElementNS(SVG, tag), attributes, children);
}

/// A drawing that words beside it tell, too.
export function drawing(className, width, height, ...children) {
  return svg(
    "svg",
    { class: className, viewBox: `0 0 ${width} ${height}`, width, height, "aria-hidden": "true" },
    ...children,
  );
}

function filled(element, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else element.setAttribute(name, value === true ? "" : String(value));
  }
  element.append(...contentOf(children));
  return element;
}

/// Only what differs is set, since a change that is none costs a layout; null and false take an attribute away.
export function setAttributes(element, attributes) {
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) element.removeAttribute(name);
    else if (element.getAttribute(name) !== String(value)) element.setAttribute(name, String(value));
  }
}

/// Replaces what is in an element.
export function fill(element, ...children) {
  element.replaceChildren(...contentOf(children));
  return element;
}

const FOCUSABLE = "a[href], button, select, input, summary, [tabindex]";

/// Likewise, of something that is shown anew by itself: the focus stays where it was among its parts.
export function refill(element, ...children) {
  const parts = () => [...element.querySelectorAll(FOCUSABLE)];
  const place = parts().indexOf(document.activeElement);
  fill(element, ...children);
  if (place >= 0) parts()[place]?.focus({ preventScroll: true });
  return element;
}

function contentOf(children) {
  return children.flat(Infinity).filter((child) => child !== null && child !== undefined && child !== false);
}

const shown = new WeakMap();

/// Refills the element with show(value) only where the value, of JSON, is another one than the last time.
export function showIfNew(element, value, show) {
  const text = JSON.stringify(value);
  if (shown.get(element) === text) return;
  shown.set(element, text);
  refill(element, show(value));
}

/// Sets a text only where it changes, so that a live region does not repeat itself.
export function setText(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

export function problem(words) {
  return h("p", { class: "problem", role: "status" }, words);
}

export function quiet(words) {
  return h("p", { class: "quiet" }, words);
}

/// The heading of a view; gets the focus when the view is opened.
export function viewHeading(text) {
  return h("h1", { tabindex: "-1" }, text);
}

/// title: more of it, for who points at it.
export function badge(level, text, title = null) {
  return h("span", { class: `badge ${level}`, title }, text);
}

export function details(title, content, { open = false, id = null, ontoggle = null } = {}) {
  return h("details", { open, id, ontoggle }, h("summary", {}, title), content);
}

export function announce(text) {
  const element = document.getElementById("announcer");
  if (element && element.textContent !== text) element.textContent = text;
}

/// options: [[value, words]]; chosen: a value, else the first is.
export function choice(words, options, chosen, onchange = null, attributes = {}) {
  const select = h(
    "select",
    { ...attributes, onchange: () => onchange?.(select.value) },
    options.map(([value, text]) => h("option", { value }, text)),
  );
  if (chosen !== null && chosen !== undefined) select.value = chosen;
  return { element: h("label", { class: "choice" }, h("span", {}, words), select), select };
}

/// null where there is nothing to list.
export function list(className, items, attributes = {}) {
  if (items.length === 0) return null;
  return h(
    "ul",
    { class: className, ...attributes },
    items.map((item) => h("li", {}, item)),
  );
}

/// pairs: [[address, words]].
export function links(pairs) {
  return h(
    "p",
    { class: "links" },
    pairs.map(([href, words]) => h("a", { href }, words)),
  );
}

/// Does what fills `place`; where it fails says there what could not be shown, unless the view is left.
export async function attempt(place, what, work) {
  try {
    await work();
  } catch (error) {
    if (error.name !== "AbortError") fill(place, problem(`${what}: ${error.message}.`));
  }
}
