#include "common/reduction/consistency.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/statistics/distributions.hpp"

namespace strobe::reduction {

double chance_of_scatter(double sum_of_squares, double degrees_of_freedom, double noise_freedom) {
  if (!(degrees_of_freedom > 0.0) || !(sum_of_squares > 0.0)) return 1.0;
  if (!std::isfinite(sum_of_squares)) return 0.0;
  if (noise_freedom > statistics::kAsGoodAsNormal)
    return statistics::chi_squared_tail(sum_of_squares, degrees_of_freedom);
  if (!(noise_freedom > 0.0)) return 1.0;
  return statistics::f_tail(sum_of_squares / degrees_of_freedom, degrees_of_freedom, noise_freedom);
}

namespace {

double square(double x) { return x * x; }

/// Of the mean diameter, by the errors of the camera's map: images weigh alike, near enough for a test.
double map_variance(const Observations& all) {
  double sum = 0.0;
  for (const ObservedMapError& error : all.map_errors) {
    double shift = 0.0;
    for (const ObservedMapError::Shift& s : error.images) shift += s.diameter_m;
    sum += square(shift / static_cast<double>(std::max<std::size_t>(error.images.size(), 1)));
  }
  return sum;
}

ResidualScatter centre_scatter(const ShotFit& fit) {
  constexpr double kTakenByLeg = 4.0;
  ResidualScatter centres;
  const geometry::Rotation2d tilt = tilt_of(fit.joint);
  for (std::size_t leg = 0; leg < 2; ++leg) {
    if (!fit.joint.legs[leg].fitted) continue;
    double sum = 0.0;
    double stated = 0.0;
    double count = 0.0;
    for (const Observation& o : fit.observations.images) {
      if (!o.use_centre || leg_index(*o.leg) != leg) continue;
      count += 1.0;
      if (o.centre_noise != NoiseGroup::stated) continue;
      stated += 1.0;
      const ImageRows rows = image_rows(fit.observations, fit.joint, tilt, o);
      sum += rows.residual[0] * rows.residual[0] + rows.residual[1] * rows.residual[1];
    }
    centres.sum_of_squares += sum;
    centres.degrees_of_freedom += stated > 0.0 ? (2.0 * count - kTakenByLeg) * stated / count : 0.0;
  }
  return centres;
}

ResidualScatter equator_scatter_of(const ShotFit& fit) {
  constexpr double kTakenByLeg = 2.0;
  ResidualScatter equators;
  for (std::size_t leg = 0; leg < 2; ++leg) {
    if (!fit.spin[leg]) continue;
    double stated = 0.0;
    const auto& readings = fit.equators[leg];
    for (std::size_t i = 0; i < readings.size(); ++i) {
      if (readings[i].estimated_noise) continue;
      stated += 1.0;
      const double residual = fit.spin[leg]->residual_rad[i];
      const double by_time = fit.spin[leg]->omega_radps * readings[i].time_sd_s;
      equators.sum_of_squares +=
          residual * residual / (readings[i].sd_rad * readings[i].sd_rad + by_time * by_time);
    }
    const double count = static_cast<double>(readings.size());
    if (!(stated > 0.0)) continue;
    equators.sum_of_squares += fit.spin[leg]->decay_square * stated / count;
    equators.degrees_of_freedom += (count - kTakenByLeg) * stated / count;
  }
  return equators;
}

ResidualScatter diameter_scatter(const ShotFit& fit) {
  const MeanDiameter diameters = mean_diameter(fit);
  if (diameters.count == 0 || diameters.estimated_noise) return {};
  return {diameters.sum_of_squares, diameters.count - 1.0};
}

ResidualScatter surface_scatter(const ShotFit& fit) {
  const Observations& all = fit.observations;
  if (all.surface_noise != NoiseGroup::stated || !all.has_surface()) return {};
  return {surface_square_sum(fit) / (all.surface_sd() * all.surface_sd()),
          static_cast<double>(all.surface_m.size()) - 2.0};
}

std::optional<double> ratio_of(const ResidualScatter& scatter) {
  if (!(scatter.degrees_of_freedom > 0.0) || !std::isfinite(scatter.sum_of_squares)) return std::nullopt;
  return std::sqrt(scatter.sum_of_squares / scatter.degrees_of_freedom);
}

}  // namespace

ResidualScatter scatter_of(const ShotFit& fit, MeasurementKind kind) {
  if (fit.joint.degenerate()) return {};
  switch (kind) {
    case MeasurementKind::centre:
      return centre_scatter(fit);
    case MeasurementKind::equator:
      return equator_scatter_of(fit);
    case MeasurementKind::diameter:
      return diameter_scatter(fit);
    case MeasurementKind::surface:
      return surface_scatter(fit);
  }
  return {};
}

double surface_square_sum(const ShotFit& fit) {
  const geometry::Rotation2d to_surface = tilt_of(fit.joint).inverse();
  double sum = 0.0;
  for (const Eigen::Vector2d& p : fit.observations.surface_m) {
    const double r = (to_surface * p).y() - fit.joint.unknowns[kHeight];
    sum += r * r;
  }
  return sum;
}

bool exceeds_noise(const ResidualScatter& scatter) {
  constexpr double kTests = static_cast<double>(kMeasurementKindCount) + 1.0;
  const double freedom = scatter.degrees_of_freedom;
  // Chi squared is skewed to the right: more than one in 740 lies above its mean by three sd.
  if (!(freedom > 0.0) || scatter.sum_of_squares < freedom + 3.0 * std::sqrt(2.0 * freedom)) return false;
  return chance_of_scatter(scatter.sum_of_squares, freedom, std::numeric_limits<double>::infinity()) <
         kFalseAlarms / kTests;
}

ResidualTest test_residuals(const ShotFit& fit) {
  ResidualTest test;
  ResidualScatter all;
  for (std::size_t i = 0; i < kMeasurementKindCount; ++i) {
    const ResidualScatter scatter = scatter_of(fit, static_cast<MeasurementKind>(i));
    all.sum_of_squares += scatter.sum_of_squares;
    all.degrees_of_freedom += scatter.degrees_of_freedom;
    test.exceeded = test.exceeded || exceeds_noise(scatter);
    test.ratios.by_kind[i] = ratio_of(scatter);
  }
  test.exceeded = test.exceeded || exceeds_noise(all);
  test.ratios.all = ratio_of(all);
  return test;
}

MeanDiameter mean_diameter(const ShotFit& fit) {
  const Observations& all = fit.observations;
  // Where the calibration is the better known no diameter is used, but all of them were measured.
  const bool any_used =
      std::any_of(all.images.begin(), all.images.end(), [](const Observation& o) { return o.use_diameter; });
  MeanDiameter diameters;
  for (const Observation& o : all.images) {
    if (!(any_used ? o.use_diameter : o.use_centre)) continue;
    const double weight = 1.0 / square(all.diameter_sd(o));
    const double off = o.diameter_m - diameters.mean_m;
    const double both = diameters.weight + weight;
    diameters.sum_of_squares += weight * (diameters.weight / both) * off * off;
    diameters.mean_m += weight / both * off;
    diameters.weight = both;
    ++diameters.count;
    diameters.estimated_noise = diameters.estimated_noise || o.diameter_noise != NoiseGroup::stated;
  }
  return diameters;
}

bool scale_contradicts_ball(const ShotFit& fit) {
  const Observations& all = fit.observations;
  if (!all.scale) return false;
  const MeanDiameter diameters = mean_diameter(fit);
  if (diameters.count == 0) return false;
  double of_mean = 1.0 / diameters.weight;
  double freedom = std::numeric_limits<double>::infinity();
  if (diameters.estimated_noise) {
    freedom = diameters.count - 1.0;
    if (freedom < 1.0) return false;
    of_mean *= diameters.sum_of_squares / freedom;
  }
  const double variance = of_mean + map_variance(all) + square(all.ball_diameter_m * all.scale_sd) +
                          square(*all.scale * all.size_sd_m());
  if (!(variance > 0.0)) return false;
  // Welch-Satterthwaite: only the mean's variance is an estimate.
  if (of_mean > 0.0) freedom *= square(variance / of_mean);
  const double off = square(diameters.mean_m - *all.scale * all.ball_diameter_m) / variance;
  return off > 9.0 &&
         chance_of_scatter(off, 1.0, freedom) < kFalseAlarms;  // below 3 sd it cannot be beyond chance
}

}  // namespace strobe::reduction
