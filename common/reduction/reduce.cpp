#include "common/reduction/reduce.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <iterator>
#include <utility>

#include "common/reduction/consistency.hpp"
#include "common/reduction/flight_effects.hpp"
#include "common/reduction/legacy.hpp"
#include "common/reduction/likely_cause.hpp"
#include "common/reduction/outliers.hpp"
#include "common/reduction/propagate.hpp"
#include "common/reduction/reduced_shot.hpp"
#include "common/reduction/shot_fit.hpp"
#include "common/reduction/spatial.hpp"
#include "common/reduction/spin_check.hpp"
#include "common/reduction/surface_check.hpp"

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

/// Kinds of which a bad one could not be singled out: images and equators of a leg, diameters of the
/// photograph, points of the surface.
void flag_redundancy(const Observations& all, FlagSet& flags) {
  int centres[2] = {0, 0};
  int equators[2] = {0, 0};
  int diameters = 0;
  for (const Observation& o : all.images) {
    if (o.use_centre) ++centres[leg_index(*o.leg)];
    if (o.use_equator) ++equators[leg_index(*o.leg)];
    if (o.use_diameter) ++diameters;
  }
  const auto few = [](int number) { return number >= 2 && number < kMinForOutlier; };
  const bool few_of_a_leg = few(centres[0]) || few(centres[1]) || few(equators[0]) || few(equators[1]);
  const bool few_points = all.has_surface() && std::ssize(all.surface_m) < kMinForOutlier;
  if (few_of_a_leg || few(diameters) || few_points) flags.set(Flag::no_redundancy);
}

Readout empty_readout(const Frame& frame, Estimator estimator) {
  Readout readout;
  readout.shot_id = frame.shot_id;
  readout.record = frame.record;
  readout.method = estimator == Estimator::best ? "best" : "two-point";
  return readout;
}

/// What hangs on a spin that may be another.
void withhold_doubtful(Readout& readout) {
  if (!readout.flags.has(Flag::spin_aliased)) return;
  if (readout.regime) readout.regime = Regime::unclear;
  readout.court_pace_conforming = false;
}

void note(const SpinCheck& spins, Readout& readout) {
  if (spins.in_doubt || spins.faster) readout.flags.set(Flag::spin_aliased);
  if (readout.flags.has(Flag::spin_aliased)) return;
  readout.spin_told_by = spins.told_by;
  if (spins.told_by.has(SpinEvidence::assumed_limit)) readout.flags.set(Flag::spin_limit_assumed);
}

using Primary = std::array<std::optional<double>, kPrimaryCount>;

Primary primary(const Readout& readout, const Crossings& crossings) {
  const Quantities& v = readout.value;
  return {v[Quantity::vx_td_mps], v[Quantity::vy_td_mps], v[Quantity::omega_td_radps], crossings[0],
          v[Quantity::vx_lo_mps], v[Quantity::vy_lo_mps], v[Quantity::omega_lo_radps], crossings[1]};
}

void add_to_sd(const Quantities& variance, Readout& readout) {
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    if (readout.sd[q] && variance[q]) readout.sd[q] = std::hypot(*readout.sd[q], std::sqrt(*variance[q]));
  }
}

void add_change(double change, DerivedNumber& number) { number.sd = std::hypot(number.sd, change); }

/// Adds what the errors of the camera's map do to sd and covariance. They move all images together, which
/// independent noise of the images would not show: the shot is fitted once more for each error, with the same
/// measurements in use.
void add_map_errors(const ShotFit& fit, const PropagationOptions& options, const Crossings& crossings,
                    Readout& readout) {
  Quantities variance;
  const Primary as_seen = primary(readout, crossings);
  const PropagationOptions numbers{options.temperature_c};
  for (const ObservedMapError& error : fit.observations.map_errors) {
    ShotFit moved = fit;
    shift(error, 1.0, moved.observations);
    refit(moved, fit.effects);
    Readout other;
    const Crossings where = propagate(moved, numbers, other);
    for (std::size_t i = 0; i < kQuantityCount; ++i) {
      const auto q = static_cast<Quantity>(i);
      const double change = difference(other.value[q], readout.value[q]);
      variance[q] = variance[q].value_or(0.0) + change * change;
    }
    if (readout.drop && other.drop) {
      add_change(other.drop->fall_height_m.value - readout.drop->fall_height_m.value,
                 readout.drop->fall_height_m);
      add_change(other.drop->rebound_height_m.value - readout.drop->rebound_height_m.value,
                 readout.drop->rebound_height_m);
    }
    if (!readout.covariance) continue;
    const Primary now = primary(other, where);
    for (std::size_t i = 0; i < kPrimaryCount; ++i) {
      for (std::size_t k = 0; k < kPrimaryCount; ++k)
        (*readout.covariance)[i][k] += difference(now[i], as_seen[i]) * difference(now[k], as_seen[k]);
    }
  }
  add_to_sd(variance, readout);
}

/// What is told, once the fit stands.
void finish(const ShotFit& fit, PropagationOptions options, const Crossings& crossings, Readout& readout) {
  if (may_lack_variance(readout)) {
    options.widened = true;
    propagate(fit, options, readout);
  }
  add_map_errors(fit, options, crossings, readout);
  withhold_doubtful(readout);
}

Readout two_point_readout(const Frame& frame, const PropagationOptions& propagation,
                          std::optional<ShotFit>& fitted) {
  Readout readout = empty_readout(frame, Estimator::two_point);
  std::optional<Observations> observations = observe(frame, readout.flags);
  if (!observations) return readout;
  flag_redundancy(*observations, readout.flags);
  keep_nearest(*observations);
  const ShotFit& fit = fitted.emplace(fit_shot(
      std::move(*observations), {.effects = flight::kNoEffects, .reject_outliers = false}, readout.flags));
  readout.mirrored = fit.observations.surface.mirrored;
  const Crossings crossings = propagate(fit, propagation, readout);
  note(check_spins(readout, fit), readout);
  finish(fit, propagation, crossings, readout);
  return readout;
}

/// Fits what the frame holds; where its surface points disagree, once more with those that agree, since the
/// line says which images are airborne. Returns nullopt if there is no line.
std::optional<ShotFit> fit_frame(const Frame& frame, const ReduceOptions& options, bool spins_open,
                                 FlagSet& flags) {
  const FitOptions fitting{.effects = options.effects.value_or(flight::Effects{}),
                           .reject_outliers = options.reject_outliers,
                           .spins_open = spins_open};
  FlagSet found;
  std::optional<Observations> observations = observe(frame, found, options.noise);
  std::optional<ShotFit> fit;
  if (observations) fit = fit_shot(std::move(*observations), fitting, found);
  const auto surface = fit && fitting.reject_outliers ? consistent_surface(frame, *fit) : std::nullopt;
  if (surface) {
    found = {};
    found.set(surface->flag);
    observations = observe(surface->frame, found, options.noise);
    fit.reset();
    if (observations) fit = fit_shot(std::move(*observations), fitting, found);
  }
  flags.merge(found);
  return fit;
}

/// Rows are residuals divided by the Cholesky factor of the noise: multiplied by it they are metres again.
std::optional<double> path_residual_px(const ShotFit& fit, const Observation& image) {
  if (!image.leg || *image.leg == Leg::contact || !fit.joint.legs[leg_index(*image.leg)].fitted)
    return std::nullopt;
  const ImageRows rows = image_rows(fit.observations, fit.joint, tilt_of(fit.joint), image);
  const double x = rows.residual[0] / rows.white.xx;
  const double y = (rows.residual[1] - rows.white.yx * x) / rows.white.yy;
  const double residual_px = std::hypot(x, y) * fit.observations.surface.px_per_unit;
  return std::isfinite(residual_px) ? std::optional(residual_px) : std::nullopt;
}

/// Images without a surface and without labels may be those of a bounce, which no single flight goes through.
/// Ten times what digitizing by hand leaves; a bounce of tennis balls leaves 0.17 or more.
bool on_one_flight(const ShotFit& fit) {
  constexpr double kFarthestOfDiameter = 0.1;
  const Observations& all = fit.observations;
  double sum = 0.0, freedom = -4.0;
  for (const Observation& o : all.images) {
    if (!o.use_centre) continue;
    sum += std::pow(path_residual_px(fit, o).value_or(0.0) / all.surface.px_per_unit, 2);
    freedom += 2.0;
  }
  const double farthest_m = kFarthestOfDiameter * all.ball_diameter_m * fit.joint.unknowns[kScale];
  return !(freedom > 0.0) || sum <= freedom * farthest_m * farthest_m;
}

/// Air is fitted first and left out again where it does not matter: it nearly always does, and costs nothing.
/// `spins_open`: a first fit left open which spin it was. Its lift is then open too, and what it made of the
/// images. `fitted` is the fit that the numbers are from.
Readout best_readout(const Frame& frame, const PropagationOptions& propagation, const ReduceOptions& options,
                     std::optional<ShotFit>& fitted, bool spins_open = false) {
  Readout readout = empty_readout(frame, Estimator::best);
  if (spins_open) readout.flags.set(Flag::spin_aliased);
  fitted = fit_frame(frame, options, spins_open, readout.flags);
  if (!fitted) return readout;
  ShotFit& fit = *fitted;
  readout.mirrored = fit.observations.surface.mirrored;
  if (!fit.observations.has_surface() && !on_one_flight(fit)) {
    readout.flags.set(Flag::degenerate_geometry);
    return readout;
  }
  flag_redundancy(fit.observations, readout.flags);
  if (contact_contradicts_surface(fit)) readout.flags.set(Flag::surface_suspect);
  if (scale_contradicts_ball(fit)) readout.flags.set(Flag::scale_contradicts_ball);
  const ResidualTest residuals = test_residuals(fit);
  readout.residual_ratios = residuals.ratios;
  if (residuals.exceeded) readout.flags.set(Flag::residuals_exceed_noise);
  Readout reduced = readout;
  const Crossings crossings = propagate(fit, propagation, reduced);
  if (!spins_open) {
    const SpinCheck spins = check_spins(reduced, fit);
    note(spins, reduced);
    if (spins.faster) {
      Frame faster = frame;
      faster.fastest_spin_radps = kTearingRim_mps / fit.observations.ball.radius_m();
      return best_readout(faster, propagation, options, fitted, !spins.far_better);
    }
    if (reduced.flags.has(Flag::spin_aliased)) return best_readout(frame, propagation, options, fitted, true);
    note(spins, readout);
  }
  reduced.flight_effects = fit.effects;
  flight::Effects kept =
      options.effects ? fit.effects : significant_effects(reduced, fit, crossings, fit.effects);
  if (!fit.joint.air_used && (kept.drag || kept.magnus)) {
    readout.flags.set(Flag::air_not_fitted);
    reduced.flags.set(Flag::air_not_fitted);
    kept.drag = kept.magnus = false;
  }
  if (kept == fit.effects) {
    finish(fit, propagation, crossings, reduced);
    return reduced;
  }
  refit(fit, kept);
  const Crossings again = propagate(fit, propagation, readout);
  finish(fit, propagation, again, readout);
  readout.flight_effects = kept;
  return readout;
}

std::optional<std::string> invalid_for(Estimator estimator, const Frame& frame) {
  if (auto complaint = validation_error(frame)) return complaint;
  if (estimator == Estimator::best || !frame.surface_px.empty()) return std::nullopt;
  return "surface_px: without a surface only the best estimator gives numbers";
}

/// Of all images: those that were left out may be what tells.
std::optional<LikelyCause> cause_of(const Frame& frame, const ReduceOptions& options, const FlagSet& flags) {
  constexpr std::array kContradictions{Flag::outlier_image, Flag::residuals_exceed_noise,
                                       Flag::scale_contradicts_ball};
  if (std::ranges::none_of(kContradictions, [&](Flag flag) { return flags.has(flag); })) return std::nullopt;
  FlagSet found;
  std::optional<Observations> observations = observe(frame, found, options.noise);
  if (!observations) return std::nullopt;
  return likely_cause(fit_shot(std::move(*observations),
                               {.effects = options.effects.value_or(flight::Effects{}),
                                .reject_outliers = false,
                                .spins_open = flags.has(Flag::spin_aliased)},
                               found));
}

/// Only a frame that states a law tells where it was measured.
bool beyond_air_law(const Frame& frame, const Readout& readout) {
  if (!frame.air_law || !(readout.flight_effects.drag || readout.flight_effects.magnus)) return false;
  const auto outside = [&law = *frame.air_law](const std::optional<double>& speed_mps) {
    return speed_mps && (*speed_mps < law.least_mps || *speed_mps > law.most_mps);
  };
  return outside(readout.value[Quantity::v_td_mps]) || outside(readout.value[Quantity::v_lo_mps]);
}

/// As if its errors had been the map's from the beginning.
void add_depth_doubt(const DepthFit& depth, const PropagationOptions& propagation, const Frame& frame,
                     ReducedShot& shot) {
  const auto doubt = depth_doubt(depth, frame, *shot.fit);
  std::vector<ObservedMapError>& errors = shot.fit->observations.map_errors;
  std::vector<ObservedMapError> of_map = std::exchange(errors, {doubt.begin(), doubt.end()});
  Readout numbers;
  add_map_errors(*shot.fit, propagation, propagate(*shot.fit, propagation, numbers), shot.readout);
  of_map.insert(of_map.end(), doubt.begin(), doubt.end());
  errors = std::move(of_map);
}

/// Once more in the plane where the third dimension asks for it; what it says joins the readout.
void add_third_dimension(const PropagationOptions& propagation, const ReduceOptions& options,
                         const Frame& frame, ReducedShot& shot) {
  if (!shot.fit || !tells_third_dimension(frame)) return;
  SpatialFit spatial = fit_spatial(frame, *shot.fit);
  if (spatial.frame) shot.readout = best_readout(*spatial.frame, propagation, options, shot.fit);
  if (shot.fit && spatial.depth && !spatial.depth->moves)
    add_depth_doubt(*spatial.depth, propagation, frame, shot);
  shot.readout.flags.merge(spatial.flags);
  if (shot.fit) add_spatial(spatial, frame, *shot.fit, shot.readout);
  withhold_doubtful(shot.readout);
  if (spatial.frame) shot.in_plane = std::move(spatial.frame);
}

/// There is no surface to touch down on.
void move_to_launch(const ReducedShot& shot, double first_image_s, Readout& readout) {
  if (readout.value == Quantities{}) return;
  Numbers& numbers = readout;
  readout.launch = Launch{std::exchange(numbers, {}), first_image_s + shot.fit->joint.legs[0].first_s};
}

}  // namespace

Result<Readout> reduce(const Frame& frame, Estimator estimator, const ReduceOptions& options) {
  if (estimator == Estimator::legacy) {
    if (const auto complaint = invalid_for(estimator, frame)) return fail(*complaint);
    return reduce_legacy(frame);
  }
  auto shot = reduce_shot(frame, estimator, options);
  if (!shot) return tl::unexpected(shot.error());
  if (options.likely_cause && estimator == Estimator::best && shot->readout.value != Quantities{})
    shot->readout.likely_cause = cause_of(shot->in_plane.value_or(frame), options, shot->readout.flags);
  if (frame.surface_px.empty() && !frame.images.empty())
    move_to_launch(*shot, frame.images.front().time_s, shot->readout);
  return std::move(shot->readout);
}

Result<ReducedShot> reduce_shot(const Frame& frame, Estimator estimator, const ReduceOptions& options) {
  assert(estimator != Estimator::legacy);
  if (const auto complaint = invalid_for(estimator, frame)) return fail(*complaint);
  ReducedShot shot;
  if (frame.lens) shot.in_plane = seen_on_axis(frame);
  const Frame& seen = shot.in_plane ? *shot.in_plane : frame;
  const PropagationOptions propagation{temperature_c(frame), options.covariance, options.by_time};
  if (estimator == Estimator::two_point) {
    shot.readout = two_point_readout(seen, propagation, shot.fit);
  } else {
    shot.readout = best_readout(seen, propagation, options, shot.fit);
    add_third_dimension(propagation, options, seen, shot);
  }
  if (beyond_air_law(frame, shot.readout)) shot.readout.flags.set(Flag::air_extrapolated);
  return shot;
}

Result<std::vector<ImageFit>> image_fits(const Frame& frame) {
  const auto shot = reduce_shot(frame, Estimator::best);
  if (!shot) return tl::unexpected(shot.error());
  std::vector<ImageFit> fits(frame.images.size());
  if (!shot->fit || shot->fit->observations.images.size() != fits.size()) return fits;
  for (std::size_t i = 0; i < fits.size(); ++i) {
    const Observation& image = shot->fit->observations.images[i];
    fits[i] = {image.leg, image.use_centre, image.use_diameter, image.use_equator,
               path_residual_px(*shot->fit, image)};
  }
  return fits;
}

}  // namespace strobe::reduction
