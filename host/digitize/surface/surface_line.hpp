// The line of the surface on the photograph, found from the plate that every flash lit. Deterministic;
// thread-safe; allocates.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "host/digitize/core/plane_map.hpp"
#include "host/digitize/core/types.hpp"
#include "host/digitize/image/photograph.hpp"

namespace strobe::digitize {

struct SurfaceLine {
  std::vector<cv::Point2d> points;  ///< plane px, left to right, at least 2
  double sd_px = 0.0;               ///< of each coordinate of a point
  /// More than 0: a plate seen from above shows a back and a front edge, so far apart. The balls' plane cuts
  /// its top somewhere between; the line lies half-way, and the doubt is in sd_px.
  double edge_separation_px = 0.0;
};

/// `outlines`: the round images found so far, none of which lies below the surface; parts of the line that
/// they cover are left out. Rejection: no_plate, line_ambiguous, imprecise.
Measured<SurfaceLine> find_surface_line(const Photograph& photograph, const PlaneMap& map,
                                        std::span<const Outline> outlines);

}  // namespace strobe::digitize
