// The image of a ball in contact: flattened below, so that its top and the width of its flat side are
// measured besides its centre. Deterministic; thread-safe; allocates.
#pragma once

#include "host/digitize/core/types.hpp"
#include "host/digitize/surface/surface_line.hpp"

namespace strobe::digitize {

struct ContactImage {
  cv::Point2d top;                 ///< farthest point of the ball from the surface
  double top_sd_px = 0.0;          ///< perpendicular to the surface
  std::optional<double> width_px;  ///< of the flat side; absent: not measurable
  std::optional<double> width_sd_px;
};

/// `outline`: fitted to the round part of the image. Rejection: imprecise.
Measured<ContactImage> measure_contact(const Outline& outline, const SurfaceLine& surface);

}  // namespace strobe::digitize
