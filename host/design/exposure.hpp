// How bright one flash's image of the ball is, and what to do about it: from the levels of a photograph that
// was measured. Pure; thread-safe; allocates.
#pragma once

#include <optional>
#include <string>

namespace strobe::host {

/// Of a photograph's numbers, as shares of what saturates.
struct PhotographedLight {
  double brightness = 0.0;  ///< of one image of the ball where it is brightest, 0 to 1; 1: it saturates
  double dark = 0.0;        ///< without an image, 0 to 1
  /// number = light^exponent, above 0, as overlaps of images tell (digitize::TransferCurve); absent: taken
  /// for proportional.
  std::optional<double> transfer_exponent;
};

struct ExposureAdvice {
  double image_light = 0.0;  ///< one image's own, over what saturates; 1 less the dark's if it saturates
  double dark_light = 0.0;
  bool is_clipped = false;     ///< image_light is a lower bound
  int images_before_clip = 0;  ///< so many may overlap at one place; 0: one saturates
  double stops = 0.0;          ///< to open (positive) or to close the aperture by, in halves; rounded down
  std::string words;           ///< "open by 1 stop: ..."
};

/// A well exposed place is at most this light; above, lamps that vary would clip.
inline constexpr double kBrightestPlace = 0.8;
/// Of one image. Below, noise tells in the outlines (commission::kMinBrightness).
inline constexpr double kMinImageLight = 0.10;

/// So that where `overlapping` images (1 to 1000) lie on one place it is as light as kBrightestPlace; where
/// one image would then be below kMinImageLight, so that it is that light, and the words say how many clip.
/// Returns nullopt without a measured photograph, or for levels out of range: not known.
std::optional<ExposureAdvice> exposure_advice(const std::optional<PhotographedLight>& measured,
                                              int overlapping);

}  // namespace strobe::host
