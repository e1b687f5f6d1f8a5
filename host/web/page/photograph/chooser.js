// Choosing an image, or a place that was not measured, by click, finger or key: the stage's tool while nothing is corrected.
import { imageAt } from "./geometry.js";

const REACH_PX = 22;

export function createChooser({ stage, marks, items, places, chosen, choose }) {
  /// Images first: places lie behind them.
  function keyAt(at) {
    const p = stage.photoPoint(at);
    const reach = REACH_PX / stage.view().scale;
    const list = items();
    const image = imageAt(list.map((item) => item.image), p, reach);
    if (image >= 0) return list[image].key;
    const place = imageAt(places(), p, reach);
    return place < 0 ? null : `place-${place}`;
  }

  stage.element.addEventListener("focusin", (event) => {
    const key = marks.keyOf(event.target);
    const image = items().find((item) => item.key === key)?.image;
    if (image && event.target.matches(":focus-visible")) stage.reveal(image.centre_px);
  });

  return {
    begin: () => null,
    click(at) {
      const key = keyAt(at);
      choose(key);
      if (key) marks.focus(key);
      return true;
    },
    key(event) {
      const key = marks.keyOf(event.target);
      if (event.key === "Escape" && chosen()) choose(null);
      else if (key && (event.key === "Enter" || event.key === " ")) choose(key === chosen() ? null : key);
      else return false;
      return true;
    },
  };
}
