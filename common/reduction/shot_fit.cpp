#include "common/reduction/shot_fit.hpp"

#include <utility>

#include "common/reduction/noise.hpp"
#include "common/reduction/outliers.hpp"

namespace strobe::reduction {
namespace {

void fit_spins(ShotFit& fit) {
  for (auto& readings : fit.equators) readings.clear();
  std::array<std::vector<EquatorReading>, 2> left_out;
  for (std::size_t i = 0; i < fit.observations.images.size(); ++i) {
    const Observation& o = fit.observations.images[i];
    if (!fit.equator_seen[i]) continue;
    auto& readings = o.use_equator ? fit.equators : left_out;
    readings[leg_index(*o.leg)].push_back({o.time_s, o.equator_rad, fit.observations.equator_sd(o),
                                           o.time_sd_s, o.equator_noise != NoiseGroup::stated, i});
  }
  for (std::size_t leg = 0; leg < 2; ++leg) fit.spin[leg] = fit_spin(fit.equators[leg], left_out[leg]);
}

bool any_estimated(const Observations& all) {
  bool any = all.surface_noise != NoiseGroup::stated;
  for (const Observation& o : all.images) {
    any = any || (o.use_centre && o.centre_noise != NoiseGroup::stated);
    any = any || (o.use_diameter && o.diameter_noise != NoiseGroup::stated);
    any = any || (o.use_equator && o.equator_noise != NoiseGroup::stated);
  }
  return any;
}

void fit_once(ShotFit& fit) {
  // The variances hardly change the fit, and the fit hardly the variances: three rounds reach rounding.
  constexpr int kMaxRounds = 6;
  const bool estimated = any_estimated(fit.observations);
  FlightModel model;
  if (fit.effects.gravity) model.gravity_mps2 = fit.observations.gravity_mps2;
  model.air = fit.air;
  for (int round = 0; round < kMaxRounds; ++round) {
    fit_spins(fit);
    for (std::size_t leg = 0; leg < 2; ++leg) {
      model.omega_radps[leg] = fit.spin[leg] ? fit.spin[leg]->omega_radps : 0.0;
    }
    fit.joint = fit_joint(fit.observations, model);
    if (!estimated || estimate_variance_components(fit) < 1e-6) return;
  }
}

/// Mirrors where the legs as fitted, without the images left out, say otherwise than the first and last image did.
void orient(ShotFit& fit) {
  const std::size_t leg = fit.joint.legs[0].fitted ? 0 : 1;
  if (fit.joint.degenerate || !fit.joint.legs[leg].fitted) return;
  const double* way = &fit.joint.unknowns[kLegStart[leg] + 2];
  const bool mirrored = fit.observations.surface.mirrored;
  if (travels_left({mirrored ? -way[0] : way[0], way[1]}) == mirrored) return;
  mirror(fit.observations);
  fit_once(fit);
}

}  // namespace

void refit(ShotFit& fit, flight::Effects effects) {
  fit.effects = effects;
  fit.air = flight::aerodynamics(fit.observations.ball, fit.observations.air_density_kgpm3, effects);
  fit_once(fit);
}

ShotFit fit_shot(Observations observations, FitOptions options, FlagSet& flags) {
  ShotFit fit;
  fit.observations = std::move(observations);
  for (const Observation& o : fit.observations.images) fit.equator_seen.push_back(o.use_equator);
  if (options.effects.drag) {
    fit.spin_decay_per_m =
        flight::kSpinDecay_per_m * fit.observations.air_density_kgpm3 / flight::kAirDensity_kgpm3;
  }
  refit(fit, options.effects);
  while (options.reject_outliers && reject_worst_outlier(fit)) {
    flags.set(Flag::outlier_image);
    fit_once(fit);
  }
  orient(fit);
  for (const auto& spin : fit.spin) {
    if (spin && spin->aliased) flags.set(Flag::spin_aliased);
  }
  if (any_estimated(fit.observations)) flags.set(Flag::sd_from_residuals);
  return fit;
}

}  // namespace strobe::reduction
