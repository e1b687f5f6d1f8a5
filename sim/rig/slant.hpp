// A camera turned about the lens: how that moves what it would have seen square to the balls' plane. A rotation about the
// lens is the homography K·R·K^-1 of the photograph (Hartley, Zisserman, Multiple View Geometry, 8.4), K = diag(f, f, 1)
// with f the lens' distance in px; then the photograph is shifted so that the foot of the axis stays where it was. Turned
// by a to the right alone, with x and y from the foot:
//   x' = x / (cos²(a)·(1 + x·tan(a)/f)),  y' = y / (cos(a)·(1 + x·tan(a)/f)).
// Plain values; thread-safe; no allocation.
#pragma once

#include <Eigen/Core>

namespace strobe::sim {

class Slant {
 public:
  /// Of a camera square to the plane.
  Slant() = default;
  /// Angles within ±0.6 rad; distance_px > 0.
  Slant(double swing_rad, double tilt_rad, double distance_px);

  bool is_none() const { return none_; }

  /// A place of the photograph, px from the axis' foot, x to the right and y up; and back.
  Eigen::Vector2d apply(const Eigen::Vector2d& square_px) const;
  Eigen::Vector2d undo(const Eigen::Vector2d& seen_px) const;
  /// d(seen)/d(square).
  Eigen::Matrix2d jacobian(const Eigen::Vector2d& square_px) const;
  /// The homography from the photograph back to that of the square camera, px from the foot.
  const Eigen::Matrix3d& undoing() const { return undoing_; }
  /// From the square camera's axes (x right, y up, z away from it) to those of the turned one.
  const Eigen::Matrix3d& rotation() const { return rotation_; }
  /// By how much the photograph was shifted.
  const Eigen::Vector2d& shift_px() const { return shift_px_; }

  struct Ellipse {
    Eigen::Vector2d centre = Eigen::Vector2d::Zero();
    double along = 0.0;  ///< semi-axis in the direction axis_rad
    double across = 0.0;
    double axis_rad = 0.0;
  };
  /// An ellipse's image, which is one again.
  Ellipse apply(const Ellipse& square) const;

 private:
  bool none_ = true;
  Eigen::Matrix3d rotation_ = Eigen::Matrix3d::Identity();
  Eigen::Vector2d shift_px_ = Eigen::Vector2d::Zero();
  Eigen::Matrix3d turning_ = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d undoing_ = Eigen::Matrix3d::Identity();
};

}  // namespace strobe::sim
