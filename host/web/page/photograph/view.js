// Which part of a photograph is on the screen. Photograph: column and row from the top, the middle of the first pixel
// at (0, 0). Screen: CSS px from the stage's upper left corner. A view is {scale, x, y}: screen = scale * (p + 0.5) + (x, y).
// Pure.

export const maxScale = 24;

export function fitScale(photo, stage) {
  return Math.min(stage.width / photo.width, stage.height / photo.height);
}

/// The whole photograph, in the middle.
export function fitView(photo, stage) {
  const scale = fitScale(photo, stage);
  return { scale, x: (stage.width - scale * photo.width) / 2, y: (stage.height - scale * photo.height) / 2 };
}

export function toScreen(view, [column, row]) {
  return [view.scale * (column + 0.5) + view.x, view.scale * (row + 0.5) + view.y];
}

export function toPhoto(view, [x, y]) {
  return [(x - view.x) / view.scale - 0.5, (y - view.y) / view.scale - 0.5];
}

/// No empty margin on a side where the photograph reaches farther than the stage; else in the middle.
export function clampView(view, photo, stage) {
  const place = (offset, length, room) =>
    length <= room ? (room - length) / 2 : Math.min(0, Math.max(room - length, offset));
  return {
    scale: view.scale,
    x: place(view.x, view.scale * photo.width, stage.width),
    y: place(view.y, view.scale * photo.height, stage.height),
  };
}

/// What is at `at` on the screen stays there.
export function zoomAt(view, at, factor, photo, stage) {
  const least = fitScale(photo, stage);
  const scale = Math.min(Math.max(view.scale * factor, least), Math.max(maxScale, least));
  const ratio = scale / view.scale;
  return clampView({ scale, x: at[0] - ratio * (at[0] - view.x), y: at[1] - ratio * (at[1] - view.y) }, photo, stage);
}

export function panBy(view, dx, dy, photo, stage) {
  return clampView({ scale: view.scale, x: view.x + dx, y: view.y + dy }, photo, stage);
}

/// Two fingers moved from `before` to `after` (two points each).
export function pinch(view, before, after, photo, stage) {
  const middle = ([a, b]) => [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2];
  const span = ([a, b]) => Math.max(1, Math.hypot(a[0] - b[0], a[1] - b[1]));
  const from = middle(before);
  const to = middle(after);
  return panBy(zoomAt(view, from, span(after) / span(before), photo, stage), to[0] - from[0], to[1] - from[1], photo, stage);
}

export function isFit(view, photo, stage) {
  return view.scale <= fitScale(photo, stage) * 1.001;
}

/// As little as possible is moved until `p` is at least `margin` inside the stage.
export function reveal(view, p, margin, photo, stage) {
  const [x, y] = toScreen(view, p);
  const push = (at, room) => Math.max(margin - at, 0) + Math.min(room - margin - at, 0);
  return panBy(view, push(x, stage.width), push(y, stage.height), photo, stage);
}

/// When the stage becomes larger or smaller: the same middle, and all of it where all of it was seen.
export function resized(view, photo, before, after) {
  if (isFit(view, photo, before)) return fitView(photo, after);
  const middle = toPhoto(view, [before.width / 2, before.height / 2]);
  const scale = Math.max(view.scale, fitScale(photo, after));
  return clampView(
    { scale, x: after.width / 2 - scale * (middle[0] + 0.5), y: after.height / 2 - scale * (middle[1] + 0.5) }, photo, after);
}

const servedWidths = [640, 1280, 2560];

/// The width to ask the server for; null: the photograph as large as it is.
export function widthToLoad(view, photo, pixelRatio) {
  const needed = view.scale * photo.width * pixelRatio;
  return servedWidths.find((width) => width >= 0.9 * needed && width < photo.width) ?? null;
}
