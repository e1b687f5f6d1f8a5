// The path of the ball through its images: two nearly straight legs that meet at the surface, with images in
// contact between them; one leg alone, as in free flight; or curved legs of free flight, joined by any number
// of bounces; or straight down and up, told apart by the flashes' times. Geometry only, no photograph.
// Deterministic; thread-safe; allocates.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <vector>

#include "host/digitize/core/types.hpp"
#include "host/digitize/surface/surface_line.hpp"

namespace strobe::digitize {

/// A wide lens without a calibration moves centres by about that share of the diameter against a smooth path.
inline constexpr double kLensOfDiameter = 0.005;
/// A ball pressed by less than this share of its radius is still where free flight has it: of 5 ms in contact
/// that is a quarter of a millisecond, in which 7 m/s change by .6 %.
inline constexpr double kFliesOfRadius = 0.05;
/// Speeds that differ by less than this share are one.
inline constexpr double kSameSpeed = 0.02;

/// An outline's centre, in axes with y up: along and up from the surface if it is known, else the plane's.
struct PathPoint {
  cv::Point2d at;
  double sd_px = 0.0;   ///< of each coordinate
  double weight = 1.0;  ///< probability-like confidence that it is a ball, 0 to 1
};

inline const PathPoint& point_at(std::span<const PathPoint> points, int i) {
  return points[static_cast<std::size_t>(i)];
}

/// Of the point's distance from a smooth path (px²): the outline's, and what that leaves out, the lens.
double variance_across(const PathPoint& point, double diameter_px);

/// What is known of the flight before it is seen.
struct FlightFacts {
  double ball_diameter_m = 0.0651;                   ///< 0.01 to 1
  double drag_per_m = 0.0;                           ///< of that ball, flight::Aerodynamics; 0: not known
  std::optional<bool> leftwards;                     ///< absent: estimated from the bounce
  std::optional<int> bounce;                         ///< whose legs and times are wanted, from 1 in time
  std::optional<std::vector<double>> flash_times_s;  ///< of all flashes, ascending

  std::span<const double> times_s() const {
    return flash_times_s ? std::span<const double>(*flash_times_s) : std::span<const double>();
  }
};

struct PathContext {
  double diameter_px = 0.0;
  bool surface_known = false;  ///< then y = 0 is the surface
  double surface_sd_px = 0.0;
  std::span<const double> flash_times_s{};  ///< ascending; empty: not known
  double gravity_pxps2 = 0.0;               ///< towards the surface
  double ball_diameter_m = 0.0651;
  double drag_per_m = 0.0;
};

std::vector<PathPoint> path_points(std::span<const Outline> outlines,
                                   const std::optional<SurfaceLine>& surface);

/// With the outlines' median diameter, which is the ball's. Refers to the facts.
PathContext path_context(std::span<const Outline> outlines, const std::optional<SurfaceLine>& surface,
                         const FlightFacts& facts);

/// Indices into the points.
struct Path {
  /// In the air: one leg after the other, and the images of each, along the path from one of its ends. Which
  /// end comes first in time is not decided here. A leg alone begins far from the surface. None is empty.
  std::vector<std::vector<int>> legs;
  std::vector<int> contact;  ///< by x
  /// Of the legs' images those that lie on either leg, where one has too few others to tell which.
  std::vector<int> ambiguous;
  bool curved = false;  ///< legs bend as gravity has it, from left to right
  /// The ball falls and rises along one line. Its legs are then told by the flashes' times, which gives the
  /// flash of each point (-1: not told), in order of time; or they are not told at all, and are one leg.
  bool straight = false;
  std::vector<int> flash;
  struct Outlier {
    int index = 0;
    bool below = false;    ///< below the surface
    bool doubled = false;  ///< one outline of two images at nearly one place
    double off_px = 0.0;   ///< distance to the nearest leg, infinite without a leg
  };
  std::vector<Outlier> outliers;

  bool undecided() const { return straight && flash.empty(); }
  bool bounces() const { return legs.size() >= 2; }
};

/// Each of the points is in exactly one of the lists.
Path find_path(std::span<const PathPoint> points, const PathContext& context);

/// Whether a ball with its centre at that height touches the surface.
bool touches(double height_px, double sd_px, const PathContext& context);

}  // namespace strobe::digitize
