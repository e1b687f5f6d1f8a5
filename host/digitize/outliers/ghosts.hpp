// Discs that ambient light draws along the ball's path between two flashes: dim, and crowded against the images
// that the flashes made. Deterministic; thread-safe; allocates.
#pragma once

#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "host/digitize/outliers/limb_agreement.hpp"

namespace strobe::digitize {

struct LitDisc {
  cv::Point2d centre;
  double diameter = 0.0;
  Limb limb{};
  bool certain = false;  ///< its limb is a ball's
};

struct Ghost {
  int index = 0;
  double share = 0.0;  ///< of the rise across the limb of the ball that it was compared with
};

/// Of discs along one path, those much dimmer than the nearest certain ball within two diameters that is no
/// ghost itself.
std::vector<Ghost> find_ghosts(std::span<const LitDisc> discs);

}  // namespace strobe::digitize
