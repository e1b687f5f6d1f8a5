// The surface line of a photograph and the change to its axes: origin on the line, x along it, y up, metres.
// Part of the reduction, not of its interface. Pure functions; thread-safe.
#pragma once

#include <optional>
#include <vector>

#include "common/flight/parabola.hpp"
#include "common/reduction/frame.hpp"

namespace strobe::reduction {

using Vec2 = flight::Vector;

/// Rotation by -tilt about the surface points' centroid, division by a first guess of the scale, and the
/// mirror image if the ball travels to the left. The fit corrects tilt, height and scale from there.
struct Levelling {
  PointPx origin_px;    ///< one of the surface points
  PointPx centroid_px;  ///< theirs, from the origin: apart, so that far coordinates do not round it
  double cos_tilt = 1.0;
  double sin_tilt = 0.0;
  double px_per_m = 1.0;
  bool mirrored = false;

  Vec2 vector(double dx_px, double dy_px) const {
    const double x = (cos_tilt * dx_px + sin_tilt * dy_px) / px_per_m;
    const double y = (cos_tilt * dy_px - sin_tilt * dx_px) / px_per_m;
    return {mirrored ? -x : x, y};
  }
  Vec2 point(const PointPx& p) const {
    return vector((p.x - origin_px.x) - centroid_px.x, (p.y - origin_px.y) - centroid_px.y);
  }
};

/// Total least squares line through the surface points (each coordinate has the same noise), tilt in
/// [-90, 90] degrees: y stays up. Nothing if the points do not span a line.
std::optional<Levelling> level(const std::vector<PointPx>& surface_px, double px_per_m);

}  // namespace strobe::reduction
