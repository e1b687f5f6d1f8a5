// What is measured of a ball in contact: it is pressed flat below, so that its top and the width of its flat
// side tell more than a centre. Deterministic; thread-safe; allocates.
#pragma once

#include "host/digitize/core/types.hpp"
#include "host/digitize/surface/surface_line.hpp"

namespace strobe::digitize {

struct ContactImage {
  cv::Point2d top;  ///< farthest point of the ball from the surface
  double top_sd_px = 0.0;
  std::optional<double> width_px;  ///< of the flat side on the surface; absent: not seen
  std::optional<double> width_sd_px;
};

/// `outline`: the ellipse through what is round of the image.
Measured<ContactImage> measure_contact(const Outline& outline, const SurfaceLine& surface);

}  // namespace strobe::digitize
