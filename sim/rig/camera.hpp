// The scene's camera, also turned about the lens: how that moves what it would have seen square to the balls'
// plane. A rotation about the lens is the homography K·R·K^-1 of the photograph (Hartley, Zisserman, Multiple
// View Geometry, 8.4), K = diag(f, f, 1) with f the lens' distance in px; then the photograph is shifted so
// that the foot of the axis stays where it was. Turned by a to the right alone, with x and y from the foot:
//   x' = x / (cos²(a)·(1 + x·tan(a)/f)),  y' = y / (cos(a)·(1 + x·tan(a)/f)).
// Plain values; thread-safe; no allocation.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <numbers>

#include "common/reduction/frame.hpp"
#include "sim/scene/scene.hpp"

namespace strobe::sim {

/// The direction of a line, in [0, pi).
inline double modulo_pi(double angle_rad) {
  return angle_rad - std::numbers::pi * std::floor(angle_rad / std::numbers::pi);
}

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

// From the scene of the impact to the photograph: a side view. Plain values, thread-safe.
//
// Without a distance the view is orthographic. With one it is that of a pinhole at `distance_m` (L) from the
// plane in which balls are to fly, whose axis stands on that plane in the middle of the view (above the
// origin, at half of height_m). With X, Y from the axis and z from the plane towards the lens a point is seen
// in that plane at (X, Y)·L/(L - z); the surface's line is in the plane (z = 0).
//
// A sphere of radius R whose centre is at X, Y, z is seen under a circular cone, of half angle beta around
// the direction at theta to the axis: tan(theta) = hypot(X, Y)/(L - z), sin(beta) = R/hypot(X, Y, L - z).
// The plane cuts the cone in an ellipse, exactly (with q = cos²(theta) - sin²(beta)):
//   centre at  L·sin(theta)·cos(theta)/q  from the axis, in the direction of (X, Y),
//   half axes  L·sin(beta)·cos(beta)/q  in that direction,  L·sin(beta)/sqrt(q)  across.
// To first order: the centre of the image is the image of the centre but for a share beta², the image is
// longer along its direction by a share theta²/2, and all of it larger by (L/(L - z))(1 + beta²/2).
// What is measured is the centre of the ellipse and the diameter of the disc of equal area, 2·sqrt(a·b).
//
// The equator is the great circle through C ± R·(cos(phi), sin(phi), 0) and the point of the sphere nearest
// to the lens' plane. It leaves the ball's outline where (C - lens)·n = -R (n: from C to the point on it),
// that is at the two psi with (L - z)·sin(psi) - u·cos(psi) = R, u = X·cos(phi) + Y·sin(phi); its angle on
// the photograph is that of the line through the images of those two points. To first order the angle changes
// by the part of (X, Y) across the line times that along it over (L - z)².
//
// The lens moves what would be seen at p (from the axis) to p·(1 + k·|p|²/r0²), r0 half the view's diagonal
// (half_width_m, height_m/2), k the scene's distortion. An extended image is seen through the derivative of
// that at its centre, 1 + 3k·|p|²/r0² along p and 1 + k·|p|²/r0² across; the centre of its area is farther
// out by the share 3k·a·b/r0², as the outer parts are the more enlarged. All to first order in k.
//
// A camera turned by swing_deg and tilt_deg sees all of that through a homography (as above), exactly but
// for the equator's angle, which is turned by its derivative at the ball's centre.

/// A circle drawn on a ball as it is seen on the photograph.
struct LineView {
  double equator_rad = 0.0;  ///< modulo pi, between its two ends on the outline, counter-clockwise
  double tilt_rad = 0.0;     ///< of that direction, as reduction::BallImage has it
};

/// The image of one ball on the photograph: an ellipse, and on it a line through its centre.
struct BallView {
  reduction::PointPx centre_px;
  double along_px = 0.0;  ///< half axes
  double across_px = 0.0;
  double axis_rad = 0.0;     ///< direction of the first
  double equator_rad = 0.0;  ///< of the line; counter-clockwise

  double diameter_px() const { return 2.0 * std::sqrt(along_px * across_px); }
};

class Camera {
 public:
  explicit Camera(const Scene& scene);

  /// A point of the focused plane, in the surface's axes but from the camera's origin on the surface.
  reduction::PointPx project(double x_m, double y_m) const { return photograph(seen(x_m, y_m, 0.0)); }

  /// Likewise a point off the plane, towards the lens.
  reduction::PointPx project(double x_m, double y_m, double off_plane_m) const {
    return photograph(seen(x_m, y_m, off_plane_m));
  }

  /// A ball with its centre there and its equator at `equator_rad` to the surface, counter-clockwise.
  BallView view(double x_m, double y_m, double off_plane_m, double equator_rad) const;

  /// The circle n·p = offset·R on a ball with its centre there; p from the centre, n of length 1, in the
  /// surface's axes. On the outline, as seen from the direction v from the ball to the lens, v·p =
  /// R²/distance.
  LineView line(double x_m, double y_m, double off_plane_m, const Eigen::Vector3d& normal,
                double offset) const;

  /// Angle on the photograph of a line in the focused plane at `angle_rad` to the surface, near the axis.
  double project_angle(double angle_rad) const;

  /// Whether a ball with its centre there is on the photograph.
  bool sees(double x_m, double y_m) const;

  /// Whether some height there is on the photograph.
  bool may_see(double x_m) const { return std::abs(x_m) <= settings_.half_width_m; }

  /// Where the axis meets the focused plane.
  reduction::PointPx foot_px() const { return photograph({0.0, 0.0}); }

  double px_per_m() const { return settings_.px_per_m; }
  double half_width_m() const { return settings_.half_width_m; }

 private:
  struct Point {
    double x = 0.0;
    double y = 0.0;
  };

  Point from_axis(double x_m, double y_m) const;
  Point seen(double x_m, double y_m, double off_plane_m) const;
  double direction_seen(const Point& centre, double depth_m, double angle_rad) const;
  void distort(BallView& view, Point& centre, double& angle_rad) const;
  reduction::PointPx photograph(const Point& seen) const;
  void slant(BallView& view) const;

  CameraSettings settings_;
  double radius_m_;
  double turn_rad_;  ///< of the surface line on the photograph
  double turn_cos_;
  double turn_sin_;
  double bend_pm2_;  ///< k/r0²
  Slant slant_;
  Eigen::Vector2d foot_px_ = Eigen::Vector2d::Zero();  ///< of the axis, on the photograph
};

}  // namespace strobe::sim
