// A straight line in the plane by total least squares. Pure; thread-safe, real-time safe, no allocation.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "common/geometry/rotation.hpp"

namespace strobe::geometry {

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

}  // namespace strobe::geometry
