// All assignments of one leg's images to flashes: in order, in steady flight under gravity and drag.
// No I/O; thread-safe; allocates.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "common/geometry/leg.hpp"
#include "common/reduction/matching/track.hpp"

namespace strobe::matching {

struct LegCandidate {
  /// For each image of the leg the number of its flash among the seen ones, ascending.
  std::vector<int> flash;
  int missed = 0;  ///< flashes between the first and the last whose image was not found
  geometry::LegFit fit{
      Eigen::Vector2d::Zero()};  ///< centres in px, weighted by 1 / TrackPoint::variance_share
  /// -2 ln of how likely the centres are at these times, but for a constant: both coordinates, in variances
  /// of the centres, of the flashes' times and of the air's pull. 2 count - 4 degrees of freedom.
  double chi_squared = 0.0;
  std::optional<geometry::Crossing> crossing;  ///< touchdown or lift-off: the centre is a radius up

  bool empty() const { return flash.empty(); }
  int first() const { return flash.front(); }
  int last() const { return flash.back(); }
};

/// Candidates in ascending order of their first flash. times_s: observed flashes, ascending. A leg without
/// images has one empty candidate; a leg of one image may have been made by any flash.
std::vector<LegCandidate> leg_candidates(std::span<const TrackPoint> images, std::span<const double> times_s,
                                         const Track& track);

}  // namespace strobe::matching
