#include "common/reduction/residual_test.hpp"

#include <cmath>
#include <limits>

#include "common/reduction/scale_check.hpp"
#include "common/reduction/variance_test.hpp"

namespace strobe::reduction {
namespace {

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
  if (all.surface_noise != NoiseGroup::stated) return {};
  const geometry::Rotation2d to_surface = tilt_of(fit.joint).inverse();
  double sum = 0.0;
  for (const Eigen::Vector2d& p : all.surface_m) {
    const double r = (to_surface * p).y() - fit.joint.unknowns[kHeight];
    sum += r * r;
  }
  sum /= all.surface_sd() * all.surface_sd();
  return {sum, static_cast<double>(all.surface_m.size()) - 2.0};
}

std::optional<double> ratio_of(const ResidualScatter& scatter) {
  if (!(scatter.degrees_of_freedom > 0.0) || !std::isfinite(scatter.sum_of_squares)) return std::nullopt;
  return std::sqrt(scatter.sum_of_squares / scatter.degrees_of_freedom);
}

}  // namespace

ResidualScatter scatter_of(const ShotFit& fit, MeasurementKind kind) {
  if (fit.joint.degenerate) return {};
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

}  // namespace strobe::reduction
