#include "common/reduction/reduce.hpp"

#include <utility>

#include "common/reduction/flight_effects.hpp"
#include "common/reduction/legacy.hpp"
#include "common/reduction/propagate.hpp"
#include "common/reduction/shot_fit.hpp"
#include "common/reduction/spin_check.hpp"

namespace strobe::reduction {
namespace {

/// Keeps the two images next to the impact, and the two next to it that show the equator. Diameters stay: the
/// mean of all of them is the scale.
void keep_nearest(Observations& all) {
  for (const Leg leg : {Leg::incoming, Leg::rebound}) {
    int centres = 0;
    int equators = 0;
    const std::size_t count = all.images.size();
    for (std::size_t i = 0; i < count; ++i) {
      Observation& o = all.images[leg == Leg::incoming ? count - 1 - i : i];
      if (o.leg != leg) continue;
      if (o.use_centre && ++centres > 2) o.use_centre = false;
      if (o.use_equator && ++equators > 2) o.use_equator = false;
    }
  }
}

void flag_redundancy(const Observations& all, FlagSet& flags) {
  int count[2] = {0, 0};
  for (const Observation& o : all.images) {
    if (o.use_centre) ++count[leg_index(*o.leg)];
  }
  // Of three images that disagree none can be singled out.
  const auto few = [](int images) { return images == 2 || images == 3; };
  if (few(count[0]) || few(count[1])) flags.set(Flag::no_redundancy);
}

Readout empty_readout(const Frame& frame, Estimator estimator) {
  Readout readout;
  readout.shot_id = frame.shot_id;
  readout.record = frame.record;
  readout.method = estimator == Estimator::best ? "best" : "two-point";
  return readout;
}

Readout two_point_readout(const Frame& frame, const PropagationOptions& propagation) {
  Readout readout = empty_readout(frame, Estimator::two_point);
  std::optional<Observations> observations = observe(frame, readout.flags);
  if (!observations) return readout;
  flag_redundancy(*observations, readout.flags);
  keep_nearest(*observations);
  const ShotFit fit = fit_shot(std::move(*observations),
                               {.effects = flight::kNoEffects, .reject_outliers = false}, readout.flags);
  readout.mirrored = fit.observations.surface.mirrored;
  propagate(fit, propagation, readout);
  if (spins_contradict_friction(readout, fit)) readout.flags.set(Flag::spin_aliased);
  return readout;
}

/// Air is fitted first and left out again where it does not matter: it nearly always does, and costs nothing.
Readout best_readout(const Frame& frame, const PropagationOptions& propagation,
                     const ReduceOptions& options) {
  Readout readout = empty_readout(frame, Estimator::best);
  std::optional<Observations> observations = observe(frame, readout.flags);
  if (!observations) return readout;
  const FitOptions fitting{.effects = options.effects.value_or(flight::Effects{}),
                           .reject_outliers = options.reject_outliers};
  ShotFit fit = fit_shot(std::move(*observations), fitting, readout.flags);
  readout.mirrored = fit.observations.surface.mirrored;
  flag_redundancy(fit.observations, readout.flags);
  Readout reduced = readout;
  const Crossings crossings = propagate(fit, propagation, reduced);
  if (spins_contradict_friction(reduced, fit)) {
    readout.flags.set(Flag::spin_aliased);
    reduced.flags.set(Flag::spin_aliased);
  }
  reduced.flight_effects = fit.effects;
  flight::Effects kept =
      options.effects ? fit.effects : significant_effects(reduced, fit, crossings, fit.effects);
  if (!fit.joint.air_used && (kept.drag || kept.magnus)) {
    readout.flags.set(Flag::air_not_fitted);
    reduced.flags.set(Flag::air_not_fitted);
    kept.drag = kept.magnus = false;
  }
  if (kept == fit.effects) return reduced;
  refit(fit, kept);
  propagate(fit, propagation, readout);
  readout.flight_effects = kept;
  return readout;
}

}  // namespace

Result<Readout> reduce(const Frame& frame, Estimator estimator, const ReduceOptions& options) {
  if (const auto complaint = validation_error(frame)) return fail(*complaint);
  if (estimator == Estimator::legacy) return reduce_legacy(frame);
  const PropagationOptions propagation{temperature_c(frame), options.covariance};
  if (estimator == Estimator::two_point) return two_point_readout(frame, propagation);
  return best_readout(frame, propagation, options);
}

}  // namespace strobe::reduction
