// Geometry of what is drawn on a photograph: column and row from the top; angles counter-clockwise as seen. Pure.

/// {major, minor, angleRad} of the centre's standard deviations in px; null where they are not known. Its covariance is that
/// of column and row, row-major.
export function uncertaintyOf(image) {
  const covariance = image.centre_cov_px2;
  if (covariance) {
    const [xx, down, , yy] = covariance.flat();
    const xy = -down;  // rows count downwards
    const middle = (xx + yy) / 2;
    const spread = Math.hypot((xx - yy) / 2, xy);
    return {
      major: Math.sqrt(Math.max(0, middle + spread)),
      minor: Math.sqrt(Math.max(0, middle - spread)),
      angleRad: Math.atan2(2 * xy, xx - yy) / 2,
    };
  }
  const sd = image.centre_sd_px;
  if (sd === null || sd === undefined) return null;
  if (!Array.isArray(sd)) return { major: sd, minor: sd, angleRad: 0 };
  return sd[0] >= sd[1] ? { major: sd[0], minor: sd[1], angleRad: 0 } : { major: sd[1], minor: sd[0], angleRad: Math.PI / 2 };
}

export function median(numbers) {
  const sorted = [...numbers].sort((a, b) => a - b);
  return sorted.length === 0 ? null : sorted[sorted.length >> 1];
}

/// How many times as large (1, 2, 5, 10, 20 ...) ellipses are drawn, so that a usual one is a quarter of a ball's radius.
export function enlargement(images) {
  const sd = median(images.map(uncertaintyOf).filter((u) => u && u.major > 0).map((u) => u.major));
  const diameter = median(images.map((image) => image.diameter_px).filter((d) => d > 0));
  if (!sd || !diameter) return 1;
  const wanted = diameter / 8 / sd;
  if (wanted <= 1) return 1;
  const decade = 10 ** Math.floor(Math.log10(wanted));
  return decade * [5, 2, 1].find((step) => step * decade <= wanted);
}

/// The points where a line at this angle leaves a circle of `radius`. The first is where the angle points to.
export function diameterEnds([column, row], radius, angleRad) {
  const dx = radius * Math.cos(angleRad);
  const dy = -radius * Math.sin(angleRad);
  return [[column + dx, row + dy], [column - dx, row - dy]];
}

/// The angle of the line from `from` to `to`, from -pi/2 (left out) to pi/2: a line has no sense.
export function lineAngleRad(from, to) {
  const angle = Math.atan2(from[1] - to[1], to[0] - from[0]);
  if (angle > Math.PI / 2) return angle - Math.PI;
  return angle <= -Math.PI / 2 ? angle + Math.PI : angle;
}

/// The piece of the straight line through `a` and `b` that lies on the photograph; null: none does.
export function lineOnPhotograph(a, b, photo) {
  const d = [b[0] - a[0], b[1] - a[1]];
  const high = [photo.width - 0.5, photo.height - 0.5];
  let from = -Infinity;
  let to = Infinity;
  for (const axis of [0, 1]) {
    if (d[axis] === 0) {
      if (a[axis] < -0.5 || a[axis] > high[axis]) return null;
      continue;
    }
    const ends = [(-0.5 - a[axis]) / d[axis], (high[axis] - a[axis]) / d[axis]].sort((x, y) => x - y);
    from = Math.max(from, ends[0]);
    to = Math.min(to, ends[1]);
  }
  if (!(from < to) || !Number.isFinite(from)) return null;
  return [from, to].map((t) => [a[0] + t * d[0], a[1] + t * d[1]]);
}

/// The straight line nearest to all the points of the surface (least squares of the rows), cut at the photograph's edge.
export function surfaceOnPhotograph(points, photo) {
  if (!points || points.length < 2) return null;
  const mean = [0, 1].map((axis) => points.reduce((sum, p) => sum + p[axis], 0) / points.length);
  let xx = 0;
  let xy = 0;
  for (const p of points) {
    xx += (p[0] - mean[0]) ** 2;
    xy += (p[0] - mean[0]) * (p[1] - mean[1]);
  }
  if (xx === 0) return null;
  return lineOnPhotograph(mean, [mean[0] + 1, mean[1] + xy / xx], photo);
}

const distanceOf = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1]);

/// Index of the point nearest to `p` of those that are within reachOf(index); -1: none is.
function nearest(points, p, reachOf) {
  const distances = points.map((point, index) => {
    const distance = distanceOf(point, p);
    return distance > reachOf(index) ? Infinity : distance;
  });
  const least = Math.min(...distances);
  return least < Infinity ? distances.indexOf(least) : -1;
}

/// Index of the image that a click at `p` means: within its disc or `reach` of its middle, and the nearest. -1: none.
export function imageAt(images, p, reach) {
  return nearest(images.map((image) => image.centre_px), p, (index) => Math.max(reach, (images[index].diameter_px ?? 0) / 2));
}

/// Name of the handle ({name: point}) within `reach` of `p`, the nearest; null: none.
export function handleAt(handles, p, reach) {
  return Object.keys(handles)[nearest(Object.values(handles), p, () => reach)] ?? null;
}

/// Whether the place is that of the image.
export const isAt = (place, image) => distanceOf(place.centre_px, image.centre_px) < (image.diameter_px ?? 0) / 4;

/// Positions in order of time: by flash, then along the flight as listed.
export function inTime(images) {
  return images.map((image, position) => ({ image, position }))
    .sort((a, b) => (a.image.flash_index ?? Infinity) - (b.image.flash_index ?? Infinity) || a.position - b.position)
    .map(({ position }) => position);
}

/// 0 where no time is known.
export function firstTime(images) {
  const times = images.map((image) => image.time_s).filter(Number.isFinite);
  return times.length > 0 ? Math.min(...times) : 0;
}

/// Places that looked like a ball and became no image, without those that an image covers.
export function hatchedPlaces({ images, unmeasured }) {
  const covered = (place) => images.some((image) => isAt(place, image));
  return (unmeasured ?? []).filter((place) => (!place.what || place.what === "image") && !covered(place));
}

/// From the scale that the digitizer states, else from the ball's diameter; null where neither is known.
export function millimetresPerPx({ images, px_per_m: scale, ball_diameter_m: ball }) {
  if (scale > 0) return 1000 / scale;
  const diameter = median(images.map((image) => image.diameter_px).filter((d) => d > 0));
  return ball > 0 && diameter ? 1000 * ball / diameter : null;
}
