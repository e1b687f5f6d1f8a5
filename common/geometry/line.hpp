// A straight line in the plane, and the surface's axes on a photograph: origin on the surface line, x along
// it, y up from it. Plain values and pure functions; thread-safe, real-time safe, no allocation.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <optional>
#include <span>

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

/// A line through `reference + centroid`. The two are kept apart so that coordinates far from zero do not
/// round their differences.
struct Line {
  Eigen::Vector2d reference = Eigen::Vector2d::Zero();
  Eigen::Vector2d centroid = Eigen::Vector2d::Zero();  ///< from the reference
  Rotation2d tilt;                                     ///< against +x, within a quarter turn

  Eigen::Vector2d origin() const { return reference + centroid; }
  Eigen::Vector2d direction() const { return {tilt.cos(), tilt.sin()}; }
  /// (along, off) of a point: its distance from the origin along the line and, positive to its left, from it.
  Eigen::Vector2d coordinates(const Eigen::Vector2d& point) const {
    return tilt.inverse() * ((point - reference) - centroid);
  }
};

/// The line with the least weighted sum of squared distances (total least squares, Pearson 1901): both
/// coordinates have the same noise. `weights` are as many as the points, or none for equal ones, all > 0.
/// Returns nullopt if the root of the weighted sum of squared distances from the centroid is not above
/// `min_spread` (the points are one point) or is not a number.
std::optional<Line> fit_line(std::span<const Eigen::Vector2d> points, std::span<const double> weights = {},
                             double min_spread = 0.0);

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
