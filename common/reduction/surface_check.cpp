#include "common/reduction/surface_check.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "common/geometry/line.hpp"
#include "common/reduction/consistency.hpp"

namespace strobe::reduction {
namespace {

/// Two lines whose chi squared differs by less than 3 sd are indistinguishable.
constexpr double kIndistinguishable = 9.0;
constexpr std::size_t kMaxExhaustive = 12;  ///< points; 2^12 subsets at most
constexpr std::size_t kMinAgreeing = 3;     ///< any two lie on a line

/// The variance that the points are held against.
struct PointNoise {
  double variance_m2 = 0.0;
  double degrees_of_freedom = std::numeric_limits<double>::infinity();
};

/// As stated, and larger by as much as the centres scatter more than stated; or the centres' as estimated
/// less the part that the points themselves have in it.
std::optional<PointNoise> point_noise(const ShotFit& fit) {
  const Observations& all = fit.observations;
  const double variance = all.surface_sd() * all.surface_sd();
  if (all.surface_noise == NoiseGroup::stated) {
    const ResidualScatter centres = scatter_of(fit, MeasurementKind::centre);
    if (!exceeds_noise(centres)) return PointNoise{variance};
    return PointNoise{variance * centres.sum_of_squares / centres.degrees_of_freedom,
                      centres.degrees_of_freedom};
  }
  const VarianceComponent& component = fit.variance_components[static_cast<std::size_t>(all.surface_noise)];
  const double own = static_cast<double>(all.surface_m.size()) - 2.0;
  const double rest = component.degrees_of_freedom - own;
  const double rest_sum = component.degrees_of_freedom * variance - surface_square_sum(fit);
  if (!(rest > 0.5) || !(rest_sum > 0.0)) return std::nullopt;
  return PointNoise{rest_sum / rest, rest};
}

bool agree(const ShotFit& fit, const PointNoise& noise) {
  const auto& points = fit.observations.surface_m;
  const double sd = fit.observations.surface_sd();
  // Three points have one degree of freedom, and with it one chance of a false alarm.
  const double chances = points.size() == 3 ? 1.0 : static_cast<double>(points.size());
  constexpr double kPassedThrough = 1e-9;  // of its variance: the line must go through the point
  for (const Eigen::Vector2d& p : points) {
    const auto row = fit.joint.factor.shared(surface_lever_m(fit.joint, p) / sd, 1.0 / sd, 0.0);
    const double left = 1.0 - dot(row, row);
    if (!(left > kPassedThrough)) continue;
    const double r = surface_residual(fit.joint, p);
    const double square = r * r / (left * noise.variance_m2);
    if (square < 9.0) continue;  // cannot be beyond chance
    if (chances * chance_of_scatter(square, 1.0, noise.degrees_of_freedom) < kFalseAlarms) return false;
  }
  return true;
}

/// Some of the points, as bits.
using Subset = std::uint32_t;

/// Sum of squared distances from their own line, in variances.
double scatter_about_line(const std::vector<Eigen::Vector2d>& points, Subset kept, const PointNoise& noise) {
  std::vector<Eigen::Vector2d> some;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if ((kept >> i & 1U) != 0) some.push_back(points[i]);
  }
  const auto line = geometry::fit_line(some);
  if (!line) return std::numeric_limits<double>::infinity();
  double sum = 0.0;
  for (const Eigen::Vector2d& p : some) {
    const double off = line->coordinates(p).y();
    sum += off * off;
  }
  return sum / noise.variance_m2;
}

/// The largest subset whose points agree. Returns nullopt if there is none of three or more and half of all,
/// or if another of its size fits nearly as well.
std::optional<Subset> agreeing_subset(const std::vector<Eigen::Vector2d>& points, const PointNoise& noise) {
  const std::size_t count = points.size();
  for (std::size_t left_out = 1; left_out <= (count - 1) / 2 && count - left_out >= kMinAgreeing;
       ++left_out) {
    double best = std::numeric_limits<double>::infinity();
    double second = best;
    Subset found = 0;
    for (Subset kept = 0; kept < (Subset{1} << count); ++kept) {
      if (static_cast<std::size_t>(std::popcount(kept)) != count - left_out) continue;
      const double scatter = scatter_about_line(points, kept, noise);
      second = std::min(second, std::max(scatter, best));
      if (scatter < best) best = scatter, found = kept;
    }
    const double freedom = static_cast<double>(count - left_out) - 2.0;
    if (chance_of_scatter(best, freedom, noise.degrees_of_freedom) < kFalseAlarms) continue;
    if (second < best + kIndistinguishable) return std::nullopt;
    return found;
  }
  return std::nullopt;
}

/// Of more points than all subsets of can be tried: one after the other the furthest from the rest, until
/// they agree. So many do not hide one another. Returns those kept.
std::optional<std::vector<bool>> agreeing_points(const std::vector<Eigen::Vector2d>& points,
                                                 const PointNoise& noise) {
  std::vector<bool> kept(points.size(), true);
  std::vector<Eigen::Vector2d> some = points;
  std::vector<std::size_t> index(points.size());
  for (std::size_t i = 0; i < index.size(); ++i) index[i] = i;
  while (2 * some.size() > points.size()) {
    const auto line = geometry::fit_line(some);
    if (!line) return std::nullopt;
    double sum = 0.0;
    double largest = -1.0;
    std::size_t worst = 0;
    for (std::size_t i = 0; i < some.size(); ++i) {
      const double square = std::pow(line->coordinates(some[i]).y(), 2);
      sum += square;
      if (square > largest) largest = square, worst = i;
    }
    const double freedom = static_cast<double>(some.size()) - 2.0;
    if (chance_of_scatter(sum / noise.variance_m2, freedom, noise.degrees_of_freedom) >= kFalseAlarms)
      return kept;
    kept[index[worst]] = false;
    some.erase(some.begin() + static_cast<std::ptrdiff_t>(worst));
    index.erase(index.begin() + static_cast<std::ptrdiff_t>(worst));
  }
  return std::nullopt;
}

std::optional<std::vector<bool>> points_to_keep(const std::vector<Eigen::Vector2d>& points,
                                                const PointNoise& noise) {
  if (points.size() > kMaxExhaustive) return agreeing_points(points, noise);
  const auto subset = agreeing_subset(points, noise);
  if (!subset) return std::nullopt;
  std::vector<bool> kept(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) kept[i] = (*subset >> i & 1U) != 0;
  return kept;
}

void keep_points(const std::vector<bool>& kept, std::vector<PointPx>& points) {
  std::vector<PointPx> left;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (kept[i]) left.push_back(points[i]);
  }
  points = std::move(left);
}

/// One-sided, 1e-4 of normal errors: some ten comparisons in a photograph, one false alarm in a thousand.
constexpr double kSigmas = 3.72;
/// A ball this near to touching, in its diameters, may be taken for one that touches, and the other way
/// round: the order of digitizing by hand.
constexpr double kLabelledByEye = 0.01;

/// A place in the levelled photograph, with the gradient of its height and a variance beyond that of the fit.
/// [m]
struct Place {
  Eigen::Vector2d at_m;
  JointVector gradient{};
  double variance_m2 = 0.0;
};

/// Of a centre there above one that touches, in the ball's diameters.
double clearance(const ShotFit& fit, const Place& place) {
  const double diameter = fit.observations.ball_diameter_m * fit.joint.unknowns[kScale];
  return surface_residual(fit.joint, place.at_m) / diameter - 0.5;
}

/// Of the clearance. The tilt's second order is left out.
double sd_of(const ShotFit& fit, const Place& place) {
  const double diameter = fit.observations.ball_diameter_m * fit.joint.unknowns[kScale];
  JointVector gradient = place.gradient;
  gradient[kTilt] -= surface_lever_m(fit.joint, place.at_m);
  gradient[kHeight] -= 1.0;
  if (!fit.observations.scale_exact())
    gradient[kScale] -= surface_residual(fit.joint, place.at_m) / fit.joint.unknowns[kScale];
  const auto y = fit.joint.factor.whitened(gradient);
  return std::sqrt(dot(y, y) + place.variance_m2) / diameter;
}

/// Whether the clearance is beyond zero upward, or beyond minus a radius downward.
bool above_touch(const ShotFit& fit, const Place& place) {
  const double by = clearance(fit, place) - kLabelledByEye;
  return by > 0.0 && by > kSigmas * sd_of(fit, place);
}
bool beneath_surface(const ShotFit& fit, const Place& place) {
  const double by = -0.5 - clearance(fit, place) - kLabelledByEye;
  return by > 0.0 && by > kSigmas * sd_of(fit, place);
}

/// Where the ball would be had it flown on along that leg.
Place on_path(const ShotFit& fit, std::size_t leg, const Observation& o) {
  const double s = fit.joint.legs[leg].scaled(o.time_s);
  const double t = s * fit.joint.legs[leg].span_s;
  const double* z = &fit.joint.unknowns[kLegStart[leg]];
  const flight::Forcing& forcing = fit.joint.forcing[leg];
  const Eigen::Vector2d bend =
      fit.joint.unknowns[kScale] * t * t * (0.5 * forcing.acceleration_mps2 + t * forcing.jerk_mps3 / 6.0);
  Place place{{z[0] + z[2] * s + bend.x(), z[1] + z[3] * s + bend.y()}};
  place.gradient[kLegStart[leg] + 1] = 1.0;
  place.gradient[kLegStart[leg] + 3] = s;
  const double by_time = o.time_sd_s * z[3] / fit.joint.legs[leg].span_s;
  place.variance_m2 = by_time * by_time;
  return place;
}

bool contradicts(const ShotFit& fit, const Observation& o) {
  const Place own{o.centre_m, {}, fit.observations.centre_variance(o)};
  return above_touch(fit, own) || beneath_surface(fit, own) || above_touch(fit, on_path(fit, 0, o)) ||
         above_touch(fit, on_path(fit, 1, o));
}

}  // namespace

std::optional<ConsistentSurface> consistent_surface(const Frame& frame, const ShotFit& fit) {
  const auto& points = fit.observations.surface_m;
  if (points.size() < kMinAgreeing || fit.joint.degenerate()) return std::nullopt;
  // A deleted square is no larger than the sum of all squares: below 9 it cannot be beyond chance. Where the
  // variance is estimated, a sum below it only makes the rest's variance larger.
  const double sd = fit.observations.surface_sd();
  if (surface_square_sum(fit) < (fit.observations.surface_noise == NoiseGroup::stated ? 9.0 : 1.0) * sd * sd)
    return std::nullopt;
  const auto noise = point_noise(fit);
  if (!noise || agree(fit, *noise)) return std::nullopt;
  ConsistentSurface consistent{frame, Flag::outlier_surface_point};
  if (const auto kept = points_to_keep(points, *noise)) {
    keep_points(*kept, consistent.frame.surface_px);
    for (MapError& error : consistent.frame.map_errors) keep_points(*kept, error.surface_px);
    return consistent;
  }
  consistent.flag = Flag::surface_suspect;
  const double freedom = static_cast<double>(points.size()) - 2.0;
  consistent.frame.surface_sd_px =
      std::sqrt(surface_square_sum(fit) / freedom) * fit.observations.surface.px_per_unit;
  return consistent;
}

bool contact_contradicts_surface(const ShotFit& fit) {
  if (fit.joint.degenerate() || !fit.joint.legs[0].fitted || !fit.joint.legs[1].fitted) return false;
  return std::any_of(fit.observations.images.begin(), fit.observations.images.end(),
                     [&](const Observation& o) { return o.leg == Leg::contact && contradicts(fit, o); });
}

}  // namespace strobe::reduction
