// How well a photograph of balls is taken: focus, exposure, and whether its numbers are proportional to
// light. Deterministic; no I/O; thread-safe; allocates.
#pragma once

#include <optional>
#include <span>

#include "host/commission/record/step_result.hpp"
#include "host/digitize/digitize.hpp"

namespace strobe::commission {

struct PictureQuality {
  int images = 0;
  double blur_px = 0.0;          ///< sd of the edges' blur, median over the outlines; 0 without any
  double saturated_share = 0.0;  ///< of the pixels within the balls' outlines
  double brightness =
      0.0;            ///< of a ball where it is brightest (its 90 % quantile), over what saturates; median
  double dark = 0.0;  ///< the photograph's 1 % quantile, over what saturates
  std::optional<digitize::TransferCurve> transfer;  ///< absent: too few images overlap
};

/// `map`: of the outlines.
PictureQuality picture_quality(const digitize::Photograph& photograph, const digitize::PlaneMap& map,
                               const digitize::Digitization& found);

/// A centre's sd grows as the root of the blur: at 1.8 px it is half as large again as with a good lens' 0.8.
/// Sharp balls of 1,000 photographs stay below 1.3 px.
inline constexpr double kMaxBlur_px = 1.8;
/// Of the pixels of balls; where light of images adds up, some saturate in a well exposed photograph.
inline constexpr double kMaxSaturatedShare = 0.02;
/// Of one image's light. Below, noise and rounding tell in the outlines.
inline constexpr double kMinBrightness = 0.10;
/// Over what saturates: room light, or a black level that takes up much of the range.
inline constexpr double kMaxDark = 0.10;

/// Of several photographs; each judges the median of them.
StepResult judge_focus(std::span<const PictureQuality> pictures);
StepResult judge_exposure(std::span<const PictureQuality> pictures);
/// The exponents' weighted mean; skipped where no photograph has enough overlaps.
StepResult judge_transfer(std::span<const PictureQuality> pictures);

}  // namespace strobe::commission
