// Tells listeners (screen readers) what came, politely; the danger banner is an alert of its own.

export function announce(text) {
  const element = document.getElementById("announcer");
  if (element && element.textContent !== text) element.textContent = text;
}
