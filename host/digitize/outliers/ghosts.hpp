// Discs that ambient light draws along the ball's path between two flashes: dim, and crowded against the
// images that the flashes made. Deterministic; thread-safe; allocates.
#pragma once

#include <limits>
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

/// Of a disc's light beside that of the nearest certain ball that is brighter and no ghost itself.
struct Lit {
  double share = 1.0;  ///< of the rise across that ball's limb
  /// log(p / (1 - p)) that the disc is a ball's rather than a ghost's; infinite where there is no such ball.
  double log_odds = std::numeric_limits<double>::infinity();
  bool ghost() const { return log_odds < 0.0; }
};

/// Of discs along one path, one for each in their order. `ambient_share` as measured on the picture; absent:
/// not known. What cannot be told from a ball leaves others that are as bright the same doubt.
std::vector<Lit> compare_light(std::span<const LitDisc> discs, std::optional<double> ambient_share);

/// That a disc is a ball's, where it has `probability` (more than 0) to be one rather than anything else but
/// a ghost. A ball's, a ghost's and another thing's exclude each other, so that by Bayes' rule their odds
/// against the ball add up: 1 / p - 1 = (1 / probability - 1) + exp(-log_odds). What the limb says is in
/// either of the two once.
double probability_beside_ghosts(double probability, const Lit& lit);

}  // namespace strobe::digitize
