// The photograph's coordinates, geometry and words.
import assert from "node:assert/strict";
import { test } from "node:test";

import * as geometry from "../../../host/web/page/photograph/geometry.js";
import * as view from "../../../host/web/page/photograph/view.js";
import { accessibleName, measuredRows, tagOf } from "../../../host/web/page/photograph/words.js";

const photo = { width: 2880, height: 1840 };
const stage = { width: 900, height: 600 };
const near = (actual, expected, tolerance = 1e-9) => {
  assert.equal(actual.length, expected.length);
  actual.forEach((value, i) => assert.ok(Math.abs(value - expected[i]) <= tolerance, `${actual} is not ${expected}`));
};

/// Numbers that differ from run to run would hide a failure: a small generator of its own.
function randoms(seed) {
  let state = seed;
  return () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state / 2 ** 32;
  };
}

test("a point of the photograph goes to the screen and back", () => {
  const random = randoms(1);
  for (let i = 0; i < 200; ++i) {
    const p = [random() * photo.width, random() * photo.height];
    const shown = { scale: 0.1 + 20 * random(), x: -5000 * random(), y: 900 * random() };
    near(view.toPhoto(shown, view.toScreen(shown, p)), p, 1e-6);
  }
});

test("the whole photograph fits, its first pixel's corner at the stage's or inside", () => {
  const fit = view.fitView(photo, stage);
  near(view.toScreen(fit, [-0.5, -0.5]), [0, (600 - 1840 * 900 / 2880) / 2]);
  near(view.toScreen(fit, [2879.5, 1839.5]), [900, 600 - (600 - 1840 * 900 / 2880) / 2], 1e-6);
});

test("zooming keeps what is under the pointer, unless the photograph's edge would come loose", () => {
  let shown = view.zoomAt(view.fitView(photo, stage), [450, 300], 4, photo, stage);
  const random = randoms(2);
  for (let i = 0; i < 100; ++i) {
    const at = [300 + 300 * random(), 200 + 200 * random()];
    const p = view.toPhoto(shown, at);
    const next = view.zoomAt(shown, at, 1.1, photo, stage);
    near(view.toScreen(next, p), at, 1e-6);
    shown = view.zoomAt(view.fitView(photo, stage), [450, 300], 4, photo, stage);
  }
});

test("whatever is done, no empty margin appears beside a photograph larger than the stage", () => {
  const random = randoms(3);
  let shown = view.fitView(photo, stage);
  for (let i = 0; i < 500; ++i) {
    const at = [900 * random(), 600 * random()];
    shown = random() < 0.5 ? view.zoomAt(shown, at, 0.5 + random(), photo, stage) :
      view.panBy(shown, 4000 * (random() - 0.5), 4000 * (random() - 0.5), photo, stage);
    const [left, top] = view.toScreen(shown, [-0.5, -0.5]);
    const [right, bottom] = view.toScreen(shown, [2879.5, 1839.5]);
    if (right - left > 900) assert.ok(left <= 1e-6 && right >= 900 - 1e-6);
    if (bottom - top > 600) assert.ok(top <= 1e-6 && bottom >= 600 - 1e-6);
    assert.ok(shown.scale <= view.maxScale && shown.scale >= view.fitScale(photo, stage) - 1e-12);
  }
});

test("two fingers that part twice as far magnify by two, about their middle", () => {
  const shown = view.zoomAt(view.fitView(photo, stage), [450, 300], 4, photo, stage);
  const p = view.toPhoto(shown, [400, 300]);
  const next = view.pinch(shown, [[350, 300], [450, 300]], [[310, 320], [510, 320]], photo, stage);
  assert.ok(Math.abs(next.scale / shown.scale - 2) < 1e-9);
  near(view.toScreen(next, p), [410, 320], 1e-6);
});

test("a stage of another size shows all where all was seen, and else the same middle", () => {
  const wide = { width: 1400, height: 700 };
  assert.deepEqual(view.resized(view.fitView(photo, stage), photo, stage, wide), view.fitView(photo, wide));
  const shown = view.zoomAt(view.fitView(photo, stage), [450, 300], 5, photo, stage);
  near(view.toPhoto(view.resized(shown, photo, stage, wide), [700, 350]), view.toPhoto(shown, [450, 300]), 1e-6);
});

test("the more is magnified, the wider a photograph is loaded, up to all of it", () => {
  const fit = view.fitView(photo, stage);
  assert.equal(view.widthToLoad(fit, photo, 1), 1280);
  assert.equal(view.widthToLoad(fit, photo, 2), 2560);
  assert.equal(view.widthToLoad({ ...fit, scale: 2 }, photo, 1), null);
  assert.equal(view.widthToLoad({ scale: 1, x: 0, y: 0 }, { width: 500, height: 400 }, 1), null);
});

test("what gets the focus is brought into sight, and what is in sight stays where it is", () => {
  const shown = view.zoomAt(view.fitView(photo, stage), [450, 300], 6, photo, stage);
  assert.deepEqual(view.reveal(shown, view.toPhoto(shown, [450, 300]), 40, photo, stage), shown);
  const moved = view.reveal(shown, [200, 1500], 40, photo, stage);
  const [x, y] = view.toScreen(moved, [200, 1500]);
  assert.ok(x >= 39.999 && x <= 860.001 && y >= 39.999 && y <= 560.001);
});

test("a covariance's ellipse has its standard deviations as half axes", () => {
  near(Object.values(geometry.uncertaintyOf({ centre_cov_px2: [[4, 0], [0, 1]] })), [2, 1, 0]);
  const turned = geometry.uncertaintyOf({ centre_cov_px2: [2.5, -1.5, -1.5, 2.5] });
  near([turned.major, turned.minor, turned.angleRad], [2, 1, Math.PI / 4]);
  assert.deepEqual(geometry.uncertaintyOf({ centre_sd_px: 0.3 }), { major: 0.3, minor: 0.3, angleRad: 0 });
  assert.equal(geometry.uncertaintyOf({ centre_sd_px: null }), null);
});

test("uncertainties are enlarged by 1, 2 or 5 times a power of ten, and never beyond a quarter of the radius", () => {
  const of = (sd) => geometry.enlargement([{ centre_sd_px: sd, diameter_px: 260 }]);
  assert.equal(of(0.03), 1000);
  assert.equal(of(0.06), 500);
  assert.equal(of(0.1), 200);
  assert.equal(of(50), 1);
  assert.equal(geometry.enlargement([]), 1);
  for (const sd of [0.011, 0.07, 0.4, 3]) assert.ok(of(sd) * sd <= 260 / 8 + 1e-9 && of(sd) * sd > 260 / 8 / 2.51);
});

test("the equator's ends are counter-clockwise as seen, and their angle is told back", () => {
  const [a, b] = geometry.diameterEnds([100, 100], 10, Math.PI / 6);
  near(a, [100 + 10 * Math.cos(Math.PI / 6), 95]);
  near(b, [100 - 10 * Math.cos(Math.PI / 6), 105]);
  for (const degrees of [-89, -30, 0, 31, 90]) {
    const angle = degrees * Math.PI / 180;
    for (const end of geometry.diameterEnds([7, 9], 40, angle)) near([geometry.lineAngleRad([7, 9], end)], [angle], 1e-12);
  }
});

test("a surface line reaches from edge to edge of the photograph, wherever its points lie", () => {
  const [a, b] = geometry.surfaceOnPhotograph([[-2893, 1563], [5710, 1517]], photo).sort((p, q) => p[0] - q[0]);
  assert.equal(a[0], -0.5);
  assert.equal(b[0], 2879.5);
  for (const p of [a, b]) assert.ok(Math.abs(p[1] - (1563 - 46 * (p[0] + 2893) / 8603)) < 1e-6);
  assert.equal(geometry.surfaceOnPhotograph([[0, 5000], [100, 5000]], photo), null);
  assert.equal(geometry.surfaceOnPhotograph(null, photo), null);
  const steep = geometry.lineOnPhotograph([50, 0], [50, 10], photo);
  near(steep.flat(), [50, -0.5, 50, 1839.5]);
});

test("a click means the nearest of the images that it is on, and a finger may miss a small one", () => {
  const images = [{ centre_px: [100, 100], diameter_px: 100 }, { centre_px: [160, 100], diameter_px: 100 }, { centre_px: [400, 100], diameter_px: 4 }];
  assert.equal(geometry.imageAt(images, [125, 100], 5), 0);
  assert.equal(geometry.imageAt(images, [135, 100], 5), 1);
  assert.equal(geometry.imageAt(images, [420, 100], 5), -1);
  assert.equal(geometry.imageAt(images, [420, 100], 24), 2);
  assert.equal(geometry.handleAt({ centre: [0, 0], rim: [10, 0] }, [7, 0], 12), "rim");
  assert.equal(geometry.handleAt({ centre: [0, 0] }, [7, 0], 5), null);
});

test("images come in order of their flashes, those of unknown ones last", () => {
  assert.deepEqual(geometry.inTime([{ flash_index: 3 }, { flash_index: null }, { flash_index: 0 }, { flash_index: 2 }]), [2, 3, 0, 1]);
});

test("places are hatched that became no image; a ghost under an image is not", () => {
  const images = [{ centre_px: [100, 100], diameter_px: 100 }];
  const unmeasured = [{ centre_px: [110, 100], what: "image" }, { centre_px: [300, 100], what: "image" }, { centre_px: [400, 100] },
    { centre_px: [500, 100], what: "equator" }];
  assert.deepEqual(geometry.hatchedPlaces({ images, unmeasured }).map((place) => place.centre_px[0]), [300, 400]);
});

test("a px is as large as the stated scale says, or as the ball's diameter", () => {
  assert.equal(geometry.millimetresPerPx({ px_per_m: 4000, images: [] }), 0.25);
  assert.equal(geometry.millimetresPerPx({ ball_diameter_m: 0.065, images: [{ diameter_px: 260 }] }), 0.25);
  assert.equal(geometry.millimetresPerPx({ images: [] }), null);
});

test("an image is told with its uncertainties in px and mm, its flash, and why it is not used", () => {
  const image = { leg: "contact", flash_index: 9, centre_px: [734.4801, 1073.812], centre_sd_px: 0.028, diameter_px: 260.37, diameter_sd_px: 0.063,
    equator_rad: Math.PI / 6, equator_sd_rad: 0.001, used: false, why_not: "touches the surface", source: "hand", residual_px: null, time_s: 0.027 };
  assert.equal(tagOf(image), "10c");
  assert.equal(accessibleName(image), "Image of flash 10, touching the surface, by hand, not used: touches the surface");
  const rows = new Map(measuredRows(image, { mmPerPx: 0.25, first_s: 0.003 }));
  assert.equal(rows.get("Column"), "734.480 ± 0.028 px");
  assert.equal(rows.get("Diameter"), "260.370 ± 0.063 px (65.093 ± 0.016 mm)");
  assert.equal(rows.get("Equator"), "30.000 ± 0.057 °");
  assert.equal(rows.get("Time"), "24.0000 ms after the first image");
  assert.equal(rows.get("In the readout"), "not used: touches the surface");
  assert.ok(!rows.has("Residual"));
  assert.equal(new Map(measuredRows({ ...image, equator_rad: null, diameter_px: 0 }, { mmPerPx: null, first_s: 0 })).get("Equator"), "not seen");
  const used = new Map(measuredRows({ ...image, used: true, diameter_used: true, equator_used: false }, { mmPerPx: 1, first_s: 0 }));
  assert.equal(used.get("In the readout"), "used for place and diameter");
});
