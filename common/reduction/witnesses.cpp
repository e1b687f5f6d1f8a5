#include "common/reduction/witnesses.hpp"

#include <cmath>

#include "common/reduction/consistency.hpp"
#include "common/reduction/likely_cause.hpp"
#include "common/reduction/reduced_shot.hpp"

namespace strobe::reduction {
namespace {

std::optional<Estimate> if_told(double value, double sd) {
  if (!std::isfinite(value) || !(sd > 0.0 && std::isfinite(sd))) return std::nullopt;
  return Estimate{value, sd};
}

std::optional<Estimate> scale_by_diameters(const ShotFit& fit) {
  const MeanDiameter diameters = mean_diameter(fit);
  const Observations& all = fit.observations;
  double variance = 1.0 / diameters.weight;
  if (diameters.estimated_noise) variance *= diameters.sum_of_squares / (diameters.count - 1.0);
  const double px_per_m = all.surface.px_per_unit / all.ball_diameter_m;
  return if_told(diameters.mean_m * px_per_m, std::sqrt(variance) * px_per_m);
}

std::optional<Estimate> surface_on_photograph(const ShotFit& fit) {
  const Observations& all = fit.observations;
  const geometry::Rotation2d& tilt = all.surface.line.tilt;
  double mean = 0.0, square_sum = 0.0;
  for (const Eigen::Vector2d& p : all.surface_m) mean += p.x() / static_cast<double>(all.surface_m.size());
  for (const Eigen::Vector2d& p : all.surface_m) square_sum += (p.x() - mean) * (p.x() - mean);
  return if_told(std::atan2(tilt.sin(), tilt.cos()), all.surface_sd() / std::sqrt(square_sum));
}

std::optional<Estimate> path_residuals_of(const ShotFit& fit) {
  const ResidualScatter centres = scatter_of(fit, MeasurementKind::centre);
  if (!(centres.degrees_of_freedom > 0.0)) return std::nullopt;
  // Fisher: the root of chi squared is nearly normal with a variance of 1/2.
  return if_told(std::sqrt(centres.sum_of_squares / centres.degrees_of_freedom),
                 std::sqrt(0.5 / centres.degrees_of_freedom));
}

std::optional<Estimate> stated_scale(const Frame& frame, const ShotFit& fit) {
  if (!frame.px_per_m) return std::nullopt;
  const double by_ball = *frame.px_per_m * fit.observations.size_sd_m() / frame.ball_diameter_m;
  return if_told(*frame.px_per_m, std::hypot(frame.px_per_m_sd.value_or(0.0), by_ball));
}

}  // namespace

Result<PhotographWitnesses> photograph_witnesses(const Frame& frame) {
  const auto shot = reduce_shot(frame, Estimator::best);
  if (!shot) return tl::unexpected(shot.error());
  PhotographWitnesses told;
  if (!shot->fit || !shot->fit->observations.has_surface() || shot->fit->joint.degenerate()) return told;
  const ShotFit& fit = *shot->fit;
  told.calibrated = frame.px_per_m.has_value();
  told.stated_px_per_m = stated_scale(frame, fit);
  told.gravity_mps2 = local_gravity(fit);
  told.diameters_px_per_m = scale_by_diameters(fit);
  told.surface_rad = surface_on_photograph(fit);
  told.path_residuals = path_residuals_of(fit);
  return told;
}

}  // namespace strobe::reduction
