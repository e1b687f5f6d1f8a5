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

function filled(element, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else element.setAttribute(name, value === true ? "" : String(value));
  }
  element.append(...contentOf(children));
  return element;
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

/// Sets a text only where it changes, so that a live region does not repeat itself.
export function setText(element, text) {
  if (element.textContent !== text) element.textContent = text;
}
