// The outline of one ball in a LocalFrame: nearly a circle; a given ellipse where perspective is known, and a
// small deviation of its own. Plain values; thread-safe; no allocation.
#pragma once

#include <cmath>
#include <opencv2/core.hpp>

namespace strobe::digitize {

struct OutlineShape {
  cv::Point2d centre;
  double radius = 0.0;
  /// Deviation oval_cos·cos 2θ + oval_sin·sin 2θ of the radius, px.
  double oval_cos = 0.0, oval_sin = 0.0;
  /// The ellipse that perspective makes: half axes over the radius, their product 1, and the longer one's
  /// direction.
  double along = 1.0, across = 1.0;
  cv::Point2d axis{1.0, 0.0};

  /// In the direction (c, s), a unit vector.
  double reach(double c, double s) const {
    double r = radius;
    if (along != across) {
      const double u = (c * axis.x + s * axis.y) / along, v = (s * axis.x - c * axis.y) / across;
      r /= std::sqrt(u * u + v * v);
    }
    return r + oval_cos * (c * c - s * s) + oval_sin * 2.0 * c * s;
  }

  /// How far inside a point is, px along the ray from the centre.
  double depth(cv::Point2d at) const {
    const double x = at.x - centre.x, y = at.y - centre.y;
    const double d = std::sqrt(x * x + y * y);
    return d > 0.0 ? reach(x / d, y / d) - d : radius;
  }
};

}  // namespace strobe::digitize
