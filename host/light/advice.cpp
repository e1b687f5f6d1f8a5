#include "host/light/advice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

namespace strobe::light {
namespace {

/// A range in which a number is well, and one beyond which it spoils the measurement.
struct Range {
  double look_below, wrong_below, look_above, wrong_above;
};

constexpr double kNone = 1e300;

Verdict judge(double value, const Range& range) {
  if (value < range.wrong_below || value > range.wrong_above) return Verdict::wrong;
  if (value < range.look_below || value > range.look_above) return Verdict::look_at;
  return Verdict::ok;
}

double percent(double share) { return 100.0 * share; }

Advice no_ball(const LightMeasures& m) {
  Advice advice{.what = "ball", .asked = "images of the ball", .verdict = Verdict::wrong};
  constexpr double kDark = 0.1, kBright = 0.5;  // of white
  if (m.bright < kDark) {
    advice.words =
        fmt::format("no ball is seen, and nothing is brighter than {:.0f} % of white", percent(m.bright));
    advice.remedy =
        "let more light in: open the aperture, raise the gain, bring the lamps nearer; lens cap off?";
  } else if (m.dark > kBright) {
    advice.words =
        fmt::format("no ball is seen, and nothing is darker than {:.0f} % of white", percent(m.dark));
    advice.remedy = "darken the room, close the aperture, or lower the gain";
  } else {
    advice.words = "no ball is seen";
    advice.remedy = "is it in the view, in focus, and of the size that the rig file's scale says?";
  }
  return advice;
}

/// The side that a share is of: both where they are alike.
std::string_view clipped_side(const Sides& clipped) {
  constexpr double kTimes = 4.0;
  if (clipped.left > kTimes * clipped.right) return "left";
  return clipped.right > kTimes * clipped.left ? "right" : "";
}

Advice clipping(const LightMeasures& m) {
  constexpr Range kClipped{-1.0, -1.0, 0.002, 0.02};
  Advice advice{.what = "clipping",
                .value = percent(m.clipped_share),
                .unit = "%",
                .asked = "none of one image's pixels at white",
                .verdict = judge(m.clipped_share, kClipped)};
  const std::string_view side = clipped_side(m.clipped);
  advice.words = fmt::format("{:.1f} % of the balls' pixels are at white", advice.value);
  if (advice.verdict == Verdict::ok) return advice;
  if (!side.empty()) advice.words += fmt::format(", most of them on the {}", side);
  advice.remedy = side.empty() ? "close the aperture, lower the gain, or move both lamps away"
                               : fmt::format("move the lamp to the {} away, or dim it", side);
  return advice;
}

Advice exposure(const LightMeasures& m) {
  constexpr Range kFelt{0.18, 0.10, 0.75, kNone};
  Advice advice{.what = "exposure",
                .value = percent(m.felt),
                .unit = "%",
                .asked = "33 to 50 % of white",
                .verdict = judge(m.felt, kFelt)};
  advice.words = fmt::format("the felt of one flash is at {:.0f} % of white", advice.value);
  if (advice.verdict == Verdict::ok) return advice;
  advice.remedy = m.felt < kFelt.look_below
                      ? "open the aperture, raise the gain, or bring the lamps nearer"
                      : "close the aperture, lower the gain, or move the lamps away: overlaps saturate";
  return advice;
}

Advice contrast(const LightMeasures& m) {
  constexpr Range kContrast{8.0, 4.0, kNone, kNone};
  const double sds = m.noise > 0.0 ? m.limb_rise / m.noise : 0.0;
  Advice advice{.what = "contrast",
                .value = sds,
                .unit = "sds of noise",
                .asked = "20 or more",
                .verdict = judge(sds, kContrast)};
  advice.words = fmt::format("across the limb light rises by {:.0f} times the noise", sds);
  if (advice.verdict == Verdict::ok) return advice;
  advice.remedy = m.background > m.limb_rise
                      ? "put something darker behind the balls, farther away"
                      : "more light or less gain; lamps farther aside light the limb better";
  return advice;
}

Advice focus(const LightMeasures& m) {
  constexpr Range kBlur{-1.0, -1.0, 1.8, 3.0};
  Advice advice{.what = "focus",
                .value = m.blur_px,
                .unit = "px",
                .asked = "at most 1.3 px",
                .verdict = judge(m.blur_px, kBlur)};
  advice.words = fmt::format("edges are blurred by {:.2f} px", m.blur_px);
  if (advice.verdict != Verdict::ok)
    advice.remedy =
        "focus on the plane in which balls fly, tape the lens; if it is in focus, open the aperture "
        "(diffraction)";
  if (!m.blur_at_px || advice.verdict == Verdict::wrong) return advice;
  constexpr double kSds = 4.0, kMinDifference_px = 0.5;
  const double difference = m.blur_at_px->right - m.blur_at_px->left;
  const double most = std::max(m.blur_at_px->left, m.blur_at_px->right);
  const bool moved = m.smear_least_px > 1.0;  // legs of different speed tell nothing of the lens
  if (moved || std::abs(difference) < std::max(kMinDifference_px, kSds * m.blur_at_sd_px) ||
      judge(most, kBlur) == Verdict::ok)
    return advice;
  advice.verdict = std::max(advice.verdict, Verdict::look_at);
  advice.words += fmt::format(", {:.1f} px at the left and {:.1f} px at the right", m.blur_at_px->left,
                              m.blur_at_px->right);
  advice.remedy =
      fmt::format("turn the camera square to the plane in which balls fly: it is not sharp on the {}",
                  difference > 0.0 ? "right" : "left");
  return advice;
}

std::optional<Advice> motion(const LightMeasures& m) {
  if (!m.smear_px) return std::nullopt;
  constexpr double kLook_px = 4.0, kWrong_px = 8.0;
  Advice advice{.what = "motion", .value = *m.smear_px, .unit = "px", .asked = "at most 4 px a flash"};
  if (m.smear_least_px > kLook_px) advice.verdict = Verdict::look_at;
  if (m.smear_least_px > kWrong_px) advice.verdict = Verdict::wrong;
  advice.words = *m.smear_px < kLook_px
                     ? "edges are as sharp along the path as across it"
                     : fmt::format("the ball moves by some {:.0f} px in a flash", *m.smear_px);
  if (advice.verdict != Verdict::ok) advice.remedy = "shorten the flashes: less power, or quicker lamps";
  return advice;
}

Advice background(const LightMeasures& m) {
  constexpr Range kDark{-1.0, -1.0, 0.10, 0.30};
  Advice advice{.what = "background",
                .value = percent(m.dark),
                .unit = "%",
                .asked = "at most 10 % of white",
                .verdict = judge(m.dark, kDark)};
  advice.words = fmt::format("the darkest of the picture is at {:.1f} % of white", advice.value);
  if (advice.verdict != Verdict::ok)
    advice.remedy =
        "darken the room, open the shutter for less long, lower the black level; what is behind the balls "
        "may be too "
        "bright";
  return advice;
}

/// What lenses and flashes themselves scatter around the ball is 1 to 2 % of a flash. A disc of a third of a
/// flash's light can no longer be told from a ball that another hides.
std::optional<Advice> ambient(const LightMeasures& m) {
  if (!m.ambient) return std::nullopt;
  constexpr Range kAmbient{-1.0, -1.0, 0.05, 0.33};
  Advice advice{.what = "ambient",
                .value = percent(*m.ambient),
                .unit = "% of a flash",
                .asked = "under 5 % of the flash",
                .verdict = judge(*m.ambient, kAmbient)};
  advice.words = fmt::format("ambient light is {:.0f} % of the flash", advice.value);
  if (advice.verdict == Verdict::ok) return advice;
  advice.words += ": it draws the ball between flashes, too";
  advice.remedy = "darken the room, or flash more strongly and close the aperture";
  return advice;
}

Advice black(const LightMeasures& m) {
  constexpr Range kBlack{-1.0, -1.0, 0.2, kNone};
  Advice advice{.what = "black",
                .value = percent(m.black_share),
                .unit = "%",
                .asked = "none of the dark cut off",
                .verdict = judge(m.black_share, kBlack)};
  advice.words = fmt::format("{:.0f} % of the pixels beside the balls are at the number 0", advice.value);
  if (advice.verdict != Verdict::ok)
    advice.remedy = "raise the camera's black level, so that the noise of the dark is not cut off";
  return advice;
}

std::optional<Advice> proportion(const LightMeasures& m) {
  Advice advice{.what = "numbers", .asked = "proportional to light"};
  if (m.jpeg) {
    advice.value = m.bits, advice.unit = "bits";
    advice.verdict = Verdict::look_at;
    advice.words = "a JPEG has a screen's curve, 8 bits and blocks";
    advice.remedy = "let the camera write RAW, or a linear TIFF or PNG of 12 bits or more";
  }
  if (!m.transfer) return m.jpeg ? std::optional(advice) : std::nullopt;
  advice.value = m.transfer->exponent;
  advice.unit = "";
  if (m.transfer->is_proportional()) {
    if (!m.jpeg) advice.words = "the file's numbers are proportional to light";
    return advice;
  }
  advice.verdict = Verdict::wrong;
  advice.words = fmt::format("the file's numbers are light to the power of {:.2f} ± {:.2f}",
                             m.transfer->exponent, m.transfer->sd);
  advice.remedy =
      "set gamma 1 and no tone curve, or let the camera write RAW; until then the curve is undone";
  if (background(m).verdict == Verdict::ok) return advice;
  advice.verdict = Verdict::look_at;
  advice.remedy = "mend the background first, since what saturates over it bends the curve; then look again";
  return advice;
}

std::optional<Advice> lamps(const LightMeasures& m) {
  if (!m.limbs) return std::nullopt;
  const bool right = m.limbs->right > m.limbs->left;
  const double least = std::min(m.limbs->left, m.limbs->right),
               most = std::max(m.limbs->left, m.limbs->right);
  constexpr double kMaxRatio = 99.0;
  const double ratio = least > most / kMaxRatio ? most / least : kMaxRatio;
  constexpr Range kRatio{-1.0, -1.0, 3.0, 6.0};
  Advice advice{.what = "lamps",
                .value = ratio,
                .asked = "limbs alike within 2 times",
                .verdict = judge(ratio, kRatio)};
  const char* const brighter = right ? "right" : "left";
  const char* const dimmer = right ? "left" : "right";
  advice.words = ratio < kMaxRatio
                     ? fmt::format("the balls' {} limbs have {:.1f} times the light of the {} ones", brighter,
                                   ratio, dimmer)
                     : fmt::format("the balls' {} limbs have no light", dimmer);
  if (advice.verdict != Verdict::ok)
    advice.remedy = fmt::format(
        "does the lamp to the {} flash, and as strongly as the other? move it nearer or farther aside",
        dimmer);
  return advice;
}

Advice flashes(const LightMeasures& m) {
  constexpr Range kWeakest{0.75, 0.4, kNone, kNone};
  Advice advice{.what = "flashes",
                .value = percent(m.weakest),
                .unit = "%",
                .asked = "all alike",
                .verdict = judge(m.weakest, kWeakest)};
  advice.words = fmt::format("the dimmest image has {:.0f} % of the others' light", advice.value);
  if (advice.verdict != Verdict::ok)
    advice.remedy = "a lamp misses flashes or does not recharge: lengthen the period, look at its cable";
  return advice;
}

}  // namespace

std::string_view name(Verdict verdict) {
  switch (verdict) {
    case Verdict::ok:
      return "ok";
    case Verdict::look_at:
      return "look at";
    case Verdict::wrong:
      return "wrong";
  }
  return "wrong";
}

std::vector<Advice> advise(const LightMeasures& m) {
  if (m.images == 0) return {no_ball(m)};
  std::vector<Advice> all{exposure(m), clipping(m), contrast(m), focus(m)};
  for (auto&& told : {motion(m), std::optional(background(m)), ambient(m), std::optional(black(m)),
                      proportion(m), lamps(m), std::optional(flashes(m))})
    if (told) all.push_back(*told);
  return all;
}

Verdict worst(const std::vector<Advice>& advice) {
  Verdict verdict = Verdict::ok;
  for (const Advice& each : advice) verdict = std::max(verdict, each.verdict);
  return verdict;
}

std::string in_short(const std::vector<Advice>& advice) {
  std::string words;
  for (const Verdict verdict : {Verdict::wrong, Verdict::look_at}) {
    for (const Advice& each : advice) {
      if (each.verdict != verdict) continue;
      words += fmt::format("{}{}: {}: {}", words.empty() ? "" : "; ", each.what, each.words, each.remedy);
    }
  }
  return words;
}

std::vector<std::string> advice_lines(const std::vector<Advice>& advice) {
  std::vector<std::string> lines;
  for (const Advice& each : advice) {
    lines.push_back(fmt::format("{:<8} {:<11} {}{}", name(each.verdict), each.what, each.words,
                                each.asked.empty() ? "" : fmt::format(" ({})", each.asked)));
    if (!each.remedy.empty()) lines.push_back(fmt::format("{:<8} {:<11} → {}", "", "", each.remedy));
  }
  return lines;
}

std::string advice_json(const LightMeasures& measures, const std::vector<Advice>& advice) {
  nlohmann::ordered_json json{{"verdict", name(worst(advice))}, {"images", measures.images}};
  json["advice"] = nlohmann::ordered_json::array();
  for (const Advice& each : advice)
    json["advice"].push_back({{"what", each.what},
                              {"value", each.value},
                              {"unit", each.unit},
                              {"asked", each.asked},
                              {"verdict", name(each.verdict)},
                              {"words", each.words},
                              {"remedy", each.remedy}});
  return json.dump();
}

}  // namespace strobe::light
