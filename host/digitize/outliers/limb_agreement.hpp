// Whether an outline is a ball's, by its limb: lamps stand still and balls are alike, so that in the same
// direction from the centre intensity rises across each image's outline by about the same amount, whatever
// lies below. A false outline put together from arcs of several images, seams or shadows rises on those arcs
// only. Deterministic; thread-safe; allocates.
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
  /// surface.
  double observed = 0.0;
  Limb limb{};

  static constexpr double kBall = 0.75, kNonBall = 0.55;  ///< agreement

  bool is_certain_ball() const { return observed >= 0.3 && agreement >= kBall; }
  /// A false outline agrees on its borrowed arcs and, by chance, on a third of the rest.
  bool is_certain_non_ball() const { return observed >= 0.15 && agreement < kNonBall; }
};

/// One for each outline, in their order. Directions below the surface are left out. The typical limb is the
/// median of the outlines seen for more than half; with fewer than 3 such, of those seen for three quarters,
/// or else of all. With fewer than 3 outlines it is each one's own median over its directions.
std::vector<LimbAgreement> compare_limbs(const Photograph& photograph, const PlaneMap& map,
                                         std::span<const Outline> outlines,
                                         const std::optional<SurfaceLine>& surface);

}  // namespace strobe::digitize
