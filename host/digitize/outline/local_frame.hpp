// The plane around one ball as a photograph's pixels sample it, and the ball's outline there. Local
// coordinates: axes as in the plane (y up), one unit is an image pixel at the origin, a point of the plane.
// The map to the photograph is approximated by a cubic polynomial, so that thousands of samples cost little.
// Plain values; thread-safe; no allocation.
#pragma once

#include <array>
#include <cmath>
#include <opencv2/core.hpp>

#include "host/digitize/core/plane_map.hpp"

namespace strobe::digitize {

class LocalFrame {
 public:
  /// Valid within `reach_px` of the centre.
  LocalFrame(const PlaneMap& map, cv::Point2d centre_image, double reach_px);

  /// Exact without a calibration.
  cv::Point2d to_image(cv::Point2d local_px) const {
    if (uncalibrated_) return {centre_image_.x + local_px.x, centre_image_.y - local_px.y};
    const double u = local_px.x / reach_px_, v = local_px.y / reach_px_;
    return {at(column_, u, v), at(row_, u, v)};
  }
  cv::Point2d from_plane(cv::Point2d plane_px) const { return (plane_px - origin_) * scale_; }
  cv::Point2d to_plane(cv::Point2d local_px) const { return origin_ + local_px * (1.0 / scale_); }
  bool is_uncalibrated() const { return uncalibrated_; }
  double scale() const { return scale_; }  ///< local px per plane px

 private:
  static constexpr int kTerms = 10;
  using Cubic = std::array<double, kTerms>;
  static double at(const Cubic& cubic, double u, double v);

  bool uncalibrated_;
  cv::Point2d centre_image_;
  cv::Point2d origin_;
  double scale_ = 1.0;
  double reach_px_;
  Cubic column_{}, row_{};  ///< image px, of the local offset over the reach
};

/// A ball's outline in a LocalFrame: a circle, or the given ellipse where perspective is known, with a small
/// ovality.
struct OutlineShape {
  cv::Point2d centre;
  double radius = 0.0;
  /// Ovality: the radius' deviation is oval_cos·cos 2θ + oval_sin·sin 2θ [px].
  double oval_cos = 0.0, oval_sin = 0.0;
  /// The perspective ellipse: semi-axes over the radius, their product 1, and the longer one's direction.
  double along = 1.0, across = 1.0;
  cv::Point2d axis{1.0, 0.0};

  /// Distance of the outline from the centre in the direction (c, s), a unit vector.
  double radius_towards(double c, double s) const {
    double r = radius;
    if (along != across) {
      const double u = (c * axis.x + s * axis.y) / along, v = (s * axis.x - c * axis.y) / across;
      r /= std::sqrt(u * u + v * v);
    }
    return r + oval_cos * (c * c - s * s) + oval_sin * 2.0 * c * s;
  }

  /// Depth of a point inside the outline along its ray from the centre [px].
  double depth(cv::Point2d at) const {
    const double x = at.x - centre.x, y = at.y - centre.y;
    const double d = std::sqrt(x * x + y * y);
    return d > 0.0 ? radius_towards(x / d, y / d) - d : radius;
  }
};

}  // namespace strobe::digitize
