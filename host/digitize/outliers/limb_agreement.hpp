// Whether an outline is a ball's, by its limb: lamps stand still and balls are alike, so that in the same
// direction from the centre intensity rises across each image's outline by about the same amount, whatever
// lies below. A false outline put together from arcs of several images, seams or shadows rises on those arcs
// only. Where a likelier outline's limb lies beside this one's, the rise is that one's. Deterministic;
// thread-safe; allocates.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "host/digitize/core/plane_map.hpp"
#include "host/digitize/core/types.hpp"
#include "host/digitize/image/photograph.hpp"
#include "host/digitize/surface/surface_line.hpp"

namespace strobe::digitize {

/// Rise of intensity from outside to inside across an outline, by direction from its centre; not-a-number
/// where it cannot be observed.
using Limb = std::array<float, 72>;

struct LimbAgreement {
  /// Fraction of the typical limb, weighted by its rise, that this outline shows too: near 1 for a ball, near
  /// the borrowed arcs' fraction for a false outline.
  double agreement = 0.0;
  /// Fraction of the circle on which the limb can be observed: not saturated, on the photograph, above the
  /// surface, and apart from likelier outlines' limbs.
  double observed = 0.0;
  Limb limb{};  ///< of the whole circle
  /// That this is a ball's outline, from the limb and from how much of it is seen, where as many are as are
  /// not: log(p / (1 - p)).
  double log_odds = 0.0;
};

/// From these on an outline is a ball's without doubt: one in twenty is none.
inline constexpr double kCertainOdds = 3.0;

/// One for each outline, in their order. Directions below the surface are left out. The typical limb is the
/// median of the outlines, each weighted by what it rises by all around. With fewer than 3 outlines it is
/// each one's own median over its directions.
std::vector<LimbAgreement> compare_limbs(const Photograph& photograph, const PlaneMap& map,
                                         std::span<const Outline> outlines,
                                         const std::optional<SurfaceLine>& surface);

}  // namespace strobe::digitize
