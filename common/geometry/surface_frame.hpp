// The surface's axes on a photograph: origin on the surface line, x along it, y up from it.
// Pure; thread-safe, real-time safe, no allocation.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "common/geometry/line.hpp"

namespace strobe::geometry {

/// From the photograph (x right, y up) to the surface: shift to the surface points' centroid, rotation by
/// -tilt, division by the scale and, for a ball that travels to the left, the mirror image.
struct SurfaceFrame {
  Line line;                 ///< of the surface, photograph's px; its left is up
  double px_per_unit = 1.0;  ///< of the surface's coordinates: 1 for px, the scale for metres
  bool mirrored = false;     ///< x points to the left

  Eigen::Vector2d from_image(const Eigen::Vector2d& point_px) const {
    const Eigen::Vector2d px = line.coordinates(point_px);
    return {(mirrored ? -px.x() : px.x()) / px_per_unit, px.y() / px_per_unit};
  }
  Eigen::Vector2d to_image(const Eigen::Vector2d& point) const {
    const Eigen::Vector2d px = point * px_per_unit;
    return line.origin() + line.tilt * Eigen::Vector2d(mirrored ? -px.x() : px.x(), px.y());
  }
};

}  // namespace strobe::geometry
