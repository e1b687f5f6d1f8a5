// What the host made of corrected images (flash, leg, used or not), laid onto the images as they are being edited. Pure.

const same_px = 1.5;

/// items: [{key, image, status}]; judged: the images of a preview or of the shot. Each judged image serves once.
export function withJudgement(items, judged) {
  const left = [...judged];
  return items.map((item) => {
    if (item.status === "removed") return item;
    const [column, row] = item.image.centre_px;
    const distances = left.map((image) => Math.hypot(image.centre_px[0] - column, image.centre_px[1] - row));
    const nearest = distances.indexOf(Math.min(...distances));
    if (nearest < 0 || distances[nearest] > same_px) return item;
    const [{ flash_index, leg, used, why_not, residual_px, time_s, source }] = left.splice(nearest, 1);
    return { ...item, image: { ...item.image, flash_index, leg, used, why_not, residual_px, time_s, source: item.status === "found" ? source : "hand" } };
  });
}
