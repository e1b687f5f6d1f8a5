// Beside the photograph: what was measured of the image that is chosen, in words, or why a place was not.
import { fill, h } from "../parts/dom.js";
import { placeName } from "./places.js";
import { measuredRows, nameOf } from "./words.js";

const HINT = "Choose an image on the photograph (click it, or Tab and Enter) to see what was measured of it, how well, or why not.";

/// Where an equator, a top … of this image was not measured: why.
function reasonsNear(image, unmeasured) {
  return unmeasured.filter((place) => place.what && place.what !== "image" &&
    Math.hypot(place.centre_px[0] - image.centre_px[0], place.centre_px[1] - image.centre_px[1]) < (image.diameter_px ?? 0) / 4);
}

export function createPanel() {
  const heading = h("h3", {}, "No image chosen");
  const list = h("dl", { class: "photograph-measured" });
  const remark = h("p", {}, HINT);
  const element = h("section", { class: "photograph-panel", "aria-live": "polite", "aria-label": "The chosen image" }, heading, remark, list);
  return {
    element,
    show({ image, place, mmPerPx, first_s, unmeasured }) {
      heading.textContent = image ? nameOf(image) : place ? "Not measured" : "No image chosen";
      remark.textContent = image ? "" : place ? placeName(place) : HINT;
      remark.hidden = Boolean(image);
      const rows = !image ? [] : [...measuredRows(image, { mmPerPx, first_s }),
        ...reasonsNear(image, unmeasured).map(({ what, why }) => [`No ${what}`, why])];
      fill(list, rows.map(([what, words]) => h("div", {}, h("dt", {}, what), h("dd", {}, words))));
      list.hidden = rows.length === 0;
    },
  };
}
