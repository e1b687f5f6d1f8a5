// How a photograph of balls is lit and focused, in numbers. Light is in shares of white, which is what a
// saturated pixel shows. Deterministic; no I/O; thread-safe; allocates.
#pragma once

#include <optional>

#include "host/digitize/digitize.hpp"

namespace strobe::light {

/// A number of a share of the picture, left and right.
struct Sides {
  double left = 0.0, right = 0.0;
};

struct LightMeasures {
  int images = 0;  ///< of the ball; without any only the first three are told
  int bits = 8;
  double bright = 0.0;  ///< the photograph's 99.9 % quantile
  double dark = 0.0;    ///< its 1 % quantile

  /// Of the pixels where one image of the ball alone is: those at white; by the halves of the balls.
  double clipped_share = 0.0;
  Sides clipped;
  /// Of one image: its 90 % quantile over the background beside it; median over the images.
  double felt = 0.0;
  double weakest = 1.0;  ///< the dimmest image's light over the median's
  /// Light across the right limbs of the balls and across the left ones, which the lamps light from aside;
  /// absent: too few of them are seen.
  std::optional<Sides> limbs;
  /// The room's light on the ball on its way between two flashes, over one flash's; absent: too little of
  /// its way is seen.
  std::optional<double> ambient;

  double background = 0.0;   ///< light beside the balls, median
  double noise = 0.0;        ///< sd of a pixel there
  double limb_rise = 0.0;    ///< light across the limb, median over its sectors
  double black_share = 0.0;  ///< of the pixels beside the balls: those at the number 0

  double blur_px = 0.0;             ///< sd of the limb's blur, median over the images
  std::optional<Sides> blur_at_px;  ///< at the picture's left- and rightmost images, by a line through them
  double blur_at_sd_px = 0.0;       ///< of either
  /// How far the ball moves in one flash, by the limb's width along the path beyond that across it; absent:
  /// too few sectors.
  std::optional<double> smear_px;
  double smear_least_px = 0.0;  ///< at 99 % at least

  std::optional<digitize::TransferCurve> transfer;  ///< absent: too few images overlap
  bool jpeg = false;                                ///< by the file's name
};

/// `map`: of the outlines.
LightMeasures measure_light(const digitize::Photograph& photograph, const digitize::PlaneMap& map,
                            const digitize::Digitization& found);

}  // namespace strobe::light
