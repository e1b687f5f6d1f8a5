#include "common/reduction/noise.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace strobe::reduction {
namespace {

/// Residuals of exact data are rounding; an sd of zero would be an infinite weight.
constexpr double kMinRelativeSd = 1e-12;
/// Fewer degrees of freedom than this are rounding of the trace.
constexpr double kMinFreedom = 0.5;

struct Scatter {
  double sum_of_squares = 0.0;
  double count = 0.0;
  double leverage = 0.0;  // sum of the measurements' shares in their fitted values
};

double square(const std::array<double, 7>& v) { return dot(v, v); }

/// Squares of the part of a residual that the centres' noise, and not a stated error in time, accounts for.
void add_centre(const ShotFit& fit, const geometry::Rotation2d& tilt, const Observation& o, Scatter& s) {
  const ImageRows rows = image_rows(fit.observations, fit.joint, tilt, o);
  const double sd = fit.observations.group_sd[NoiseGroup::centre];
  for (std::size_t k = 0; k < 2; ++k) {
    const double residual = rows.residual[k] * sd;
    s.sum_of_squares += residual * residual;
    s.count += 1.0;
    s.leverage += square(fit.joint.factor.whitened(leg_index(*o.leg), rows.row[k]));
  }
}

void add_diameter(const ShotFit& fit, const Observation& o, Scatter& s) {
  const Observations& all = fit.observations;
  const double r = (o.diameter_m - fit.joint.unknowns[kScale] * all.ball_diameter_m) / o.diameter_sd_m;
  s.sum_of_squares += r * r;
  s.count += 1.0;
  s.leverage += square(fit.joint.factor.shared(0.0, 0.0, all.ball_diameter_m / all.diameter_sd(o)));
}

void add_surface(const ShotFit& fit, Eigen::Vector2d point, Scatter& s) {
  const double r = surface_residual(fit.joint, point) / fit.observations.surface_sd_m;
  const double sd = fit.observations.surface_sd();
  s.sum_of_squares += r * r;
  s.count += 1.0;
  s.leverage += square(fit.joint.factor.shared(surface_lever_m(fit.joint, point) / sd, 1.0 / sd, 0.0));
}

Scatter scatter(const ShotFit& fit, NoiseGroup noise) {
  const Observations& all = fit.observations;
  const geometry::Rotation2d tilt = tilt_of(fit.joint);
  Scatter s;
  for (const Observation& o : all.images) {
    const bool centre = o.use_centre && o.centre_noise == noise && fit.joint.legs[leg_index(*o.leg)].fitted;
    if (centre) add_centre(fit, tilt, o, s);
    if (o.use_diameter && o.diameter_noise == noise) add_diameter(fit, o, s);
  }
  if (all.surface_noise == noise) {
    for (const Eigen::Vector2d& p : all.surface_m) add_surface(fit, p, s);
  }
  return s;
}

Scatter equator_scatter(const ShotFit& fit) {
  Scatter s;
  for (std::size_t leg = 0; leg < 2; ++leg) {
    if (!fit.spin[leg]) continue;
    assert(fit.spin[leg]->residual_rad.size() == fit.equators[leg].size());
    for (std::size_t i = 0; i < fit.equators[leg].size(); ++i) {
      const EquatorReading& reading = fit.equators[leg][i];
      if (!reading.estimated_noise) continue;
      // Less the part of a stated error in time.
      const double by_time = fit.spin[leg]->omega_radps * reading.time_sd_s;
      const double square = reading.sd_rad * reading.sd_rad;
      const double residual =
          fit.spin[leg]->residual_rad[i] / fit.observations.images[reading.index].equator_sd_rad;
      s.sum_of_squares += residual * residual * (square / (square + by_time * by_time));
      s.count += 1.0;
      s.leverage += fit.spin[leg]->leverage[i];
    }
  }
  return s;
}

}  // namespace

double estimate_variance_components(ShotFit& fit) {
  double largest = 0.0;
  for (const NoiseGroup noise :
       {NoiseGroup::centre, NoiseGroup::surface, NoiseGroup::diameter, NoiseGroup::equator}) {
    const bool equator = noise == NoiseGroup::equator;
    const Scatter s = equator ? equator_scatter(fit) : scatter(fit, noise);
    VarianceComponent& component = fit.variance_components[static_cast<std::size_t>(noise)];
    component = {s.count > 0.0, s.count - s.leverage};
    // Absurd coordinates overflow to NaN, which is no freedom either.
    const bool known = component.degrees_of_freedom >= kMinFreedom && std::isfinite(s.sum_of_squares);
    if (!known) component.degrees_of_freedom = 0.0;
    if (!component.used || !known) continue;
    const double floor = kMinRelativeSd * (equator ? 1.0 : fit.observations.ball_diameter_m);
    const double sd = std::max(std::sqrt(s.sum_of_squares / component.degrees_of_freedom), floor);
    double& now = fit.observations.group_sd[noise];
    largest = std::max(largest, std::abs(sd - now) / now);
    now = sd;
  }
  return largest;
}

}  // namespace strobe::reduction
