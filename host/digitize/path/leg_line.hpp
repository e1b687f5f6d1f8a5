// A leg of flight on the photograph: a straight line, slightly bent by gravity. Plain values; thread-safe;
// allocates.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <vector>

#include "host/digitize/path/path.hpp"

namespace strobe::digitize {

struct LegLine {
  cv::Point2d origin;
  cv::Point2d along{1.0, 0.0};  ///< unit vector
  double bend_per_px = 0.0;     ///< distance from the straight line = bend·place²
  std::vector<int> members;     ///< ascending
  double weight = 0.0;          ///< sum of the members'
  /// Of offset (px), slope and bend (1/px) at the origin; zero for a line that is only looked along.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();

  /// Along the line from the origin, and distance from the leg, positive to its left.
  double place(cv::Point2d p) const { return (p - origin).dot(along); }
  double off(cv::Point2d p) const;
  /// The leg's own sd there, across it.
  double sd(cv::Point2d p) const;
};

/// The band in which legs gather their images, and in which images lie on one line, in diameters.
inline constexpr double kBandOfDiameter = 0.12;
/// In diameters. Two centres closer than this are at one place: they give no direction, two images there
/// share one outline, and flights whose tops differ by less are as high.
inline constexpr double kSamePlaceOfDiameter = 0.1;
/// In diameters. Outlines nearer to each other than this are as good as always of one thing.
inline constexpr double kSameThingOfDiameter = 0.2;
/// Lines within 6 degrees of each other are not told apart by their directions.
inline constexpr double kSameDirection = 0.1;

/// Largest distance of an inlier from its leg, whose own sd there is `leg_sd_px`.
double leg_tolerance(const PathPoint& point, double diameter_px, double leg_sd_px = 0.0);

/// Every leg with two or more inliers among `eligible`, most inliers by weight first, at most `max_lines`.
std::vector<LegLine> leg_lines(std::span<const PathPoint> points, std::span<const int> eligible,
                               double diameter_px, std::size_t max_lines);

// Which of the straight legs found are the ball's way down and its way up. Geometry and chance only.
// Deterministic; thread-safe; allocates.

/// How far apart the ball may touch down and lift off, in diameters: 9 ms at 20 m/s.
inline constexpr double kLongestContact = 2.8;
/// In diameters: how far a bounce may be from where its legs' images and lines have it.
inline constexpr double kBounceNoise = 0.4;
/// Images that fix a line.
inline constexpr std::size_t kMinOwnImages = 2;

/// Where a leg is a radius above the surface.
struct Crossing {
  double x = 0.0;
  double side = 0.0;  ///< where the leg lies from there: -1 left, +1 right, 0 straight above
};

/// Returns nullopt if the leg is parallel to the surface.
std::optional<Crossing> crossing(const LegLine& line, double diameter_px);

/// The leg's image that is farthest from a place.
cv::Point2d far_end(std::span<const PathPoint> points, const LegLine& leg, cv::Point2d from);

/// A further leg must explain more than this weight of images.
double leg_cost(const PathContext& context);

/// The leg or the two legs that explain most of `airborne`, the heavier line first; `lines` as leg_lines()
/// gives them. Two meet: at the surface, or without one so that chance would hardly lead the second through
/// what is no ball.
std::vector<LegLine> choose_legs(std::span<const PathPoint> points, std::span<const int> airborne,
                                 std::span<const LegLine> lines, const PathContext& context);

}  // namespace strobe::digitize
