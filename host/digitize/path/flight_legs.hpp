// The legs of a path of any number of bounces, each a curve of free flight that joins the next. Geometry
// only. Deterministic; thread-safe; allocates.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <vector>

#include "host/digitize/path/path.hpp"

namespace strobe::digitize {

// How many curves chance alone would lead as closely through as many points. Pure; thread-safe.
// Moisan, Stival: A probabilistic criterion to detect rigid point matches, IJCV 57 (2004): the a-contrario
// RANSAC.

/// Places are no better known than this, whatever the residuals.
inline constexpr double kMinResidual_px = 0.1;

/// log10 of the number of curves of `parameters` parameters expected by chance with `members` or more of
/// `points` points, thrown at random over the view, on a band that covers `share` of it (0 to 1). members <=
/// points.
double log10_curves_by_chance(std::size_t points, std::size_t members, std::size_t parameters, double share);

/// Likewise, of a curve whose members are so far from it: with as many of the nearest as are the least likely
/// by chance, for an uncertain image far off says nothing against the others. `share_per_px` as below.
double log10_nearest_by_chance(std::size_t points, std::vector<double> off_px, std::size_t parameters,
                               double share_per_px);

/// What part of the view of these points, a diameter around them, a band along a path across it covers for
/// each px of its width.
double share_of_view_per_px(std::span<const PathPoint> points, std::span<const int> eligible,
                            double diameter_px);

// A leg of free flight on the photograph, however strongly bent: a parabola whose axis is the picture's
// vertical, and with more images the conic that perspective, a camera held askew and the air make of it.
// Plain values; thread-safe; allocates.

/// v = a + b u + c u² + p u v + q v² in diameters from an origin; least squares of the distances from it.
class FlightCurve {
 public:
  /// How many of the five terms are fitted: a line, a parabola, a conic.
  enum class Shape { line = 2, parabola = 3, conic = 5 };

  /// Through points[members], as many at different x as the shape has terms; the conic, whose last two terms
  /// have a prior, through 3. Returns nullopt if the curve turns back over itself along them, or is bent
  /// upwards beyond its uncertainty.
  static std::optional<FlightCurve> fit(std::span<const PathPoint> points, std::span<const int> members,
                                        double diameter_px, Shape shape = Shape::conic);

  /// Distance of a place from the curve, positive above, and the curve's own sd there.
  double off(cv::Point2d p) const;
  double sd(cv::Point2d p) const;
  /// Height and slope of the curve at x. Returns nullopt where it has none.
  std::optional<double> height(double x) const;
  std::optional<double> slope(double x) const;

 private:
  using Terms = Eigen::Matrix<double, 5, 1>;

  Terms terms(cv::Point2d p) const;
  double gradient(cv::Point2d p) const;
  bool solve(std::span<const PathPoint> points, std::span<const int> members, int shape);
  bool is_flight(std::span<const PathPoint> points, std::span<const int> members) const;

  cv::Point2d origin_;
  double unit_px_ = 1.0;
  Terms value_ = Terms::Zero();
  Eigen::Matrix<double, 5, 5> covariance_ = Eigen::Matrix<double, 5, 5>::Zero();
};

struct FlightLeg {
  FlightCurve curve;
  std::vector<int> members;  ///< by x
  double weight = 0.0;       ///< sum of the members'
};

/// Legs from left to right, each of more images than chance would lead a curve through, once in a thousand
/// photographs; none if there is no such leg. A leg beside another joins it in a bounce.
std::vector<FlightLeg> flight_legs(std::span<const PathPoint> points, std::span<const int> eligible,
                                   const PathContext& context);

}  // namespace strobe::digitize
