// Rotation of the plane. Plain value; thread-safe, real-time safe, no allocation.
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace strobe::geometry {

/// Counter-clockwise rotation. Eigen's Rotation2D keeps the angle and takes its sine and cosine at each
/// product; this keeps these two.
class Rotation2d {
 public:
  Rotation2d() = default;  ///< the identity
  explicit Rotation2d(double angle_rad) : cos_(std::cos(angle_rad)), sin_(std::sin(angle_rad)) {}

  double cos() const { return cos_; }
  double sin() const { return sin_; }
  Rotation2d inverse() const { return {cos_, -sin_}; }
  Eigen::Vector2d operator*(const Eigen::Vector2d& v) const {
    return {cos_ * v.x() - sin_ * v.y(), sin_ * v.x() + cos_ * v.y()};
  }

 private:
  Rotation2d(double cos, double sin) : cos_(cos), sin_(sin) {}

  double cos_ = 1.0;
  double sin_ = 0.0;
};

}  // namespace strobe::geometry
