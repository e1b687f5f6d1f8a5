// What is said of an image, in words and rounded numbers. Pure.
import { fixed, inWords, significant } from "../words/numbers.js";
import { uncertaintyOf } from "./geometry.js";

const LEGS = {
  incoming: { letter: "i", words: "incoming" },
  contact: { letter: "c", words: "touching the surface" },
  rebound: { letter: "r", words: "rebound" },
};
const DEGREES = 180 / Math.PI;
const isKnown = (value) => value !== null && value !== undefined;

export const legOf = (image) => LEGS[image.leg] ?? { letter: "?", words: "leg not known" };

/// "5i": number of the flash and letter of the leg; "?" where one is not known.
export function tagOf(image) {
  return (isKnown(image.flash_index) ? String(image.flash_index + 1) : "?") + legOf(image).letter;
}

export function nameOf(image) {
  const flash = isKnown(image.flash_index) ? `Image of flash ${image.flash_index + 1}` : "Image of an unknown flash";
  return `${flash}, ${legOf(image).words}`;
}

export function useOf(image) {
  if (image.used === false) return image.why_not ? `not used: ${image.why_not}` : "not used";
  return image.used ? "used" : "";
}

/// For who does not see the picture: what it tells at a glance.
export function accessibleName(image) {
  return [nameOf(image), image.source === "hand" && "by hand", useOf(image)].filter(Boolean).join(", ");
}

function number(value, sd, unit, mmPerPx) {
  if (!isKnown(value)) return "not measured";
  const words = inWords({ value, sd }, unit);
  return mmPerPx ? `${words} (${inWords({ value: value * mmPerPx, sd: isKnown(sd) ? sd * mmPerPx : null }, "mm")})` : words;
}

function sdWords({ major, minor }, mmPerPx) {
  const mm = (px) => (mmPerPx ? ` (${significant(px * mmPerPx)} mm)` : "");
  if (major - minor < 0.05 * major) return `${significant(major)} px${mm(major)} in all directions`;
  return `${significant(minor)} px${mm(minor)} to ${significant(major)} px${mm(major)}, by direction`;
}

/// "used for place and equator": of an image that the readout uses, its numbers that it uses.
function usedFor(image) {
  if (image.used !== true || image.diameter_used === undefined) return useOf(image);
  const parts = ["place", image.diameter_used && "diameter", image.equator_used && "equator"].filter(Boolean);
  return `used for ${parts.length > 1 ? `${parts.slice(0, -1).join(", ")} and ${parts.at(-1)}` : parts[0]}`;
}

/// Rows [what, words] of the panel. mmPerPx: null where there is no scale; first_s: the time of the shot's first image.
export function measuredRows(image, { mmPerPx, first_s: first }) {
  const sd = uncertaintyOf(image);
  const seen = isKnown(image.equator_rad);
  const rows = [
    ["Column", number(image.centre_px[0], sd?.major, "px")],
    ["Row", number(image.centre_px[1], sd?.major, "px")],
    ["Middle's sd", sd ? sdWords(sd, mmPerPx) : "not known"],
    ["Diameter", image.diameter_px > 0 ? number(image.diameter_px, image.diameter_sd_px, "px", mmPerPx) : "not measured"],
    ["Equator", seen ? number(image.equator_rad * DEGREES, isKnown(image.equator_sd_rad) ? image.equator_sd_rad * DEGREES : null, "°") : "not seen"],
    ["Leg", legOf(image).words],
    ["Flash", isKnown(image.flash_index) ? String(image.flash_index + 1) : "not known"],
  ];
  if (Number.isFinite(image.time_s)) rows.push(["Time", `${fixed((image.time_s - first) * 1e3, 4)} ms after the first image`]);
  if (Number.isFinite(image.residual_px)) rows.push(["Residual", `${significant(image.residual_px)} px from the fitted flight`]);
  if (useOf(image)) rows.push(["In the readout", usedFor(image)]);
  if (image.source) rows.push(["Measured", image.source === "hand" ? "by hand" : "by the digitizer"]);
  return rows;
}
