// Whether an outline is a ball's, by the light itself: lamps stand still and balls are alike, so that in the
// same direction from its centre each image's light rises across its outline by about as much as any other's,
// whatever lies under it. An outline put together from arcs of several images, of seams or of shadows has
// that rise on those arcs alone. Deterministic; thread-safe; allocates.
#pragma once

#include <span>
#include <vector>

#include "host/digitize/core/plane_map.hpp"
#include "host/digitize/core/types.hpp"
#include "host/digitize/image/photograph.hpp"
#include "host/digitize/surface/surface_line.hpp"

namespace strobe::digitize {

/// What the light says of one outline.
struct LimbAgreement {
  /// Share of the light that rises across the others' outlines, in the directions that can be told, by which
  /// it rises here too: near 1 for a ball, near the share of borrowed arcs for what is none.
  double share = 0.0;
  double told = 0.0;  ///< share of the turn that can be told: not saturated, not off the photograph or below
};

/// One for each outline, in their order. Directions that lie below the surface are left out. What is usual is
/// the median of all outlines; with fewer than 3 it is each one's own median over its directions.
std::vector<LimbAgreement> compare_limbs(const Photograph& photograph, const PlaneMap& map,
                                         std::span<const Outline> outlines,
                                         const std::optional<SurfaceLine>& surface);

}  // namespace strobe::digitize
