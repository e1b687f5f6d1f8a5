// How much the ball's images on a photograph hide each other's outlines, by geometry alone. Pure; allocates.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "common/reduction/frame.hpp"

namespace strobe::host {

/// Depths that are told apart: within no other disc, within one ...; the last stands for all deeper ones.
inline constexpr std::size_t kOverlapDepths = 5;

/// Shares of an outline by the number of other images' discs that they lie within; their sum is 1.
struct Overlap {
  std::array<double, kOverlapDepths> shares{1.0};

  /// Within any.
  double share() const { return 1.0 - shares[0]; }
};

/// Of each image, all discs alike. The diameter must be > 0. A disc at the same place counts for the whole
/// outline.
std::vector<Overlap> overlaps(const std::vector<reduction::PointPx>& centres_px, double diameter_px);

/// Share of each image's outline that lies within other images' discs.
std::vector<double> overlap_shares(const std::vector<reduction::PointPx>& centres_px, double diameter_px);

}  // namespace strobe::host
