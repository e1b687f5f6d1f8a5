// Which outlines are the ball's images: checks of precision, size, limb, path, ghosts and spacing. Each outline that
// fails one is added to `rejected`. Deterministic for any number of threads; thread-safe; allocates.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "host/digitize/core/plane_map.hpp"
#include "host/digitize/core/types.hpp"
#include "host/digitize/image/photograph.hpp"
#include "host/digitize/surface/surface_line.hpp"

namespace strobe::digitize {

/// Checks that need no path: precision, and the size that the outlines agree on. Neither counts for what
/// is certainly a ball: a poor sd is a result, and real sizes vary as the path comes nearer.
std::vector<Outline> select_by_size(const Photograph& photograph, const PlaneMap& map,
                                    std::vector<Outline> outlines, const std::optional<SurfaceLine>& surface,
                                    std::vector<Unmeasured>& rejected);

struct FlightFacts {
  double ball_diameter_m = 0.0;
  std::span<const double> flash_times_s;  ///< ascending; empty: not known
};

/// Checks of limb, path, ghosts, spacing, and of the precision of images in contact.
std::vector<Outline> select_by_path(const Photograph& photograph, const PlaneMap& map,
                                    std::vector<Outline> outlines, const std::optional<SurfaceLine>& surface,
                                    const FlightFacts& facts, std::vector<Unmeasured>& rejected);

}  // namespace strobe::digitize
