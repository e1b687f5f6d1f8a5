// Whether a photograph's numbers are proportional to light, told by the photograph itself: where two images
// of the ball overlap their light adds up. At each crossing of two outlines, light in both less that in one
// is that in the other less that in none; numbers that are a power of the light do so for one exponent alone.
// Deterministic; no I/O; thread-safe; allocates.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <span>

#include "host/digitize/core/plane_map.hpp"
#include "host/digitize/core/types.hpp"
#include "host/digitize/image/photograph.hpp"

namespace strobe::digitize {

/// number = light^exponent, both over the largest.
struct TransferCurve {
  double exponent = 1.0;  ///< 1: proportional; 0.45: as on a screen
  double sd = 0.0;        ///< from the crossings' scatter
  int crossings = 0;
  double scatter = 0.0;  ///< sd of single crossings' exponents, over the exponent

  /// Proportional within what the crossings tell, and within what matters: an exponent of 0.85 widens a ball
  /// by about its diameter's usual sd. A wide scatter is that of a ball's holes or panels, and tells of no
  /// curve.
  bool is_proportional() const;
};

/// Returns nullopt if fewer than five crossings of two outlines are clear of a third, bright enough and not
/// saturated.
std::optional<TransferCurve> measure_transfer(const Photograph& photograph, const PlaneMap& map,
                                              std::span<const Outline> outlines);

/// The photograph in numbers proportional to light.
Photograph linearized(const Photograph& photograph, const TransferCurve& curve);

}  // namespace strobe::digitize
