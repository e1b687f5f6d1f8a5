// Which of the straight legs found are the ball's way down and its way up. Geometry and chance only. Deterministic;
// thread-safe; allocates.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <vector>

#include "host/digitize/path/leg_line.hpp"
#include "host/digitize/path/path.hpp"

namespace strobe::digitize {

/// How far apart the ball may touch down and lift off, in diameters: 9 ms at 20 m/s.
inline constexpr double kLongestContact = 2.8;
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

/// The leg or the two legs that explain most of `airborne`, the heavier line first; `lines` as leg_lines() gives them.
/// Two meet: at the surface, or without one so that chance would hardly lead the second through what is no ball.
std::vector<LegLine> choose_legs(std::span<const PathPoint> points, std::span<const int> airborne,
                                 std::span<const LegLine> lines, const PathContext& context);

}  // namespace strobe::digitize
