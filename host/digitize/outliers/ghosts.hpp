// Discs that ambient light draws along the ball's path between two flashes: dim, and crowded against the
// images that the flashes made. Deterministic; thread-safe; allocates.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <vector>

#include "host/digitize/outliers/ambient.hpp"
#include "host/digitize/outliers/limb_agreement.hpp"

namespace strobe::digitize {

struct LitDisc {
  cv::Point2d centre;
  double diameter = 0.0;
  Limb limb{};
  double log_odds = 0.0;  ///< log(p / (1 - p)) that this is a ball's outline
};

struct Ghost {
  int index = 0;
  double share = 0.0;  ///< of the rise across the limb of the ball that it was compared with
};

/// Of discs along one path, those more likely ghosts than balls by their light beside that of the nearest
/// certain ball that is no ghost itself. `ambient_share` as measured on the picture; absent: not known.
std::vector<Ghost> find_ghosts(std::span<const LitDisc> discs, std::optional<double> ambient_share);

}  // namespace strobe::digitize
