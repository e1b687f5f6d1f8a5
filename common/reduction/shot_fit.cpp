#include "common/reduction/shot_fit.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "common/reduction/consistency.hpp"
#include "common/reduction/equator_consensus.hpp"
#include "common/reduction/lift_misfit.hpp"
#include "common/reduction/outliers.hpp"
#include "common/reduction/running_statistics.hpp"

namespace strobe::reduction {
namespace {

/// Between any two airborne images of the shot, of whichever leg.
double shortest_interval_s(const Observations& all) {
  double shortest = std::numeric_limits<double>::infinity();
  const Observation* before = nullptr;
  for (const Observation& o : all.images) {
    if (o.leg == Leg::contact) continue;
    if (before) shortest = std::min(shortest, o.time_s - before->time_s);
    before = &o;
  }
  return shortest;
}

/// Of a leg: equators that were seen, and are (not) in use.
void read_equators(const ShotFit& fit, std::size_t leg, bool used, std::vector<EquatorReading>& readings) {
  for (std::size_t i = 0; i < fit.observations.images.size(); ++i) {
    const Observation& o = fit.observations.images[i];
    if (!fit.equator_seen[i] || o.use_equator != used || leg_index(*o.leg) != leg) continue;
    readings.push_back({o.time_s, o.equator_rad, fit.observations.equator_sd(o), o.time_sd_s,
                        o.equator_noise != NoiseGroup::stated, i});
  }
}

void fit_spins(ShotFit& fit, const std::array<SpinSearch, 2>& search) {
  for (std::size_t leg = 0; leg < 2; ++leg) {
    fit.equators[leg].clear();
    fit.equators[leg].reserve(fit.observations.images.size());
    read_equators(fit, leg, true, fit.equators[leg]);
    std::vector<EquatorReading> left_out;
    read_equators(fit, leg, false, left_out);
    fit.spin[leg] = fit_spin(fit.equators[leg], left_out, search[leg]);
  }
  assert(fit.equator_seen.size() == fit.observations.images.size());
}

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

/// Replaces the estimated variances by those of the residuals: sum of squares over (number of measurements -
/// trace of their rows of the hat matrix). A group without residuals keeps its first guess and has 0 degrees
/// of freedom. Returns the largest relative change of a standard deviation.
/// Source: Förstner's simplified estimator; Koch, Parameter Estimation and Hypothesis Testing, 3.6.
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

bool any_estimated(const Observations& all) {
  bool any = all.surface_noise != NoiseGroup::stated;
  for (const Observation& o : all.images) {
    any = any || (o.use_centre && o.centre_noise != NoiseGroup::stated);
    any = any || (o.use_diameter && o.diameter_noise != NoiseGroup::stated);
    any = any || (o.use_equator && o.equator_noise != NoiseGroup::stated);
  }
  return any;
}

/// What is known of a leg's lift besides the spin as fitted: its sd, or that it may be another, or any.
AirError lift_error(const ShotFit& fit, std::size_t leg, double fastest_radps) {
  const double speed = mean_speed_mps(fit.observations, leg);
  const auto lift = [&](double omega) { return lift_per_s(fit.air, speed, omega); };
  const auto& spin = fit.spin[leg];
  // Uniform between the fastest topspin and backspin.
  if (!spin) return {0.0, lift(fastest_radps) / std::numbers::sqrt3, true};
  const double as_fitted = lift(spin->omega_radps);
  // Away from zero, so that topspin and backspin are mirror images.
  const double more = std::copysign(std::sqrt(spin->variance), spin->omega_radps);
  const double by_spin = lift(spin->omega_radps + more) - as_fitted;
  if (!fit.spins_open || spin->alternatives_radps.empty())
    return {0.0, std::hypot(by_spin, fit.air.law.lift_share_sd * as_fitted), false};
  RunningStatistics lifts;
  double largest = std::abs(as_fitted);
  lifts.add(as_fitted);
  for (const double omega : spin->alternatives_radps) {
    lifts.add(lift(omega));
    largest = std::max(largest, std::abs(lift(omega)));
  }
  const double spread = lifts.population_sd();
  return {lifts.mean() - as_fitted, std::hypot(spread, fit.air.law.lift_share_sd * largest), true};
}

AirErrors air_errors(const ShotFit& fit) {
  AirErrors errors;
  const double fastest_radps = fit.observations.fastest_spin_radps();
  if (fit.effects.drag) errors[kDragError].sd = fit.air.law.drag_share_sd();
  if (fit.effects.magnus) {
    for (std::size_t leg = 0; leg < 2; ++leg) errors[kLiftError[leg]] = lift_error(fit, leg, fastest_radps);
  }
  for (std::size_t p = 0; p < kAirErrorCount; ++p) errors[p].mean += fit.air_shift[p];
  return errors;
}

/// One step suffices for errors within tolerances; an open lift is large enough to bend the path's own jerk.
void fit_paths(ShotFit& fit, FlightModel model) {
  const AirErrors errors = air_errors(fit);
  fit.joint = fit_joint(fit.observations, model);
  fit.air_fit = fit_air(fit.observations, fit.air, errors, {}, fit.joint);
  if (std::ranges::none_of(errors, [](const AirError& e) { return e.open; })) return;
  model.air.drag_per_m *= 1.0 + fit.air_fit.value[kDragError];
  for (std::size_t leg = 0; leg < 2; ++leg) model.more_lift_per_s[leg] = fit.air_fit.value[kLiftError[leg]];
  fit.joint = fit_joint(fit.observations, model);
  fit.air_fit = fit_air(fit.observations, fit.air, errors, fit.air_fit.value, fit.joint);
}

void fit_once(ShotFit& fit) {
  // The variances hardly change the fit, and the fit hardly the variances: three rounds reach rounding.
  constexpr int kMaxRounds = 6;
  const bool estimated = any_estimated(fit.observations);
  const std::array<SpinSearch, 2> search = spin_search(fit);
  fit.noise_status = FitStatus::converged;
  FlightModel model;
  if (fit.effects.gravity) model.gravity_mps2 = fit.observations.gravity_mps2;
  model.air = fit.air;
  for (int round = 0; round < kMaxRounds; ++round) {
    fit_spins(fit, search);
    for (std::size_t leg = 0; leg < 2; ++leg) {
      model.omega_radps[leg] = fit.spin[leg] ? fit.spin[leg]->omega_radps : 0.0;
    }
    fit_paths(fit, model);
    if (!estimated || estimate_variance_components(fit) < 1e-6) return;
  }
  fit.noise_status = FitStatus::iteration_limit;
}

/// Whether the angles leave the spin open within the window of the train, where an image of the leg that
/// could have told is lacking or has no equator in use. Where all have theirs friction decides: see
/// spin_check.hpp.
bool aliased(const ShotFit& fit, std::size_t leg) {
  const auto& spin = fit.spin[leg];
  if (!spin) return false;
  if (spin->near_limit) return true;
  const auto& images = fit.observations.images;
  const bool unread = std::ranges::any_of(images, [&](const Observation& o) {
    return o.leg != Leg::contact && leg_index(*o.leg) == leg && !o.use_equator;
  });
  // Between one interval of the train and two; a code varies them by less.
  const bool lacking = spin->interval_s > 1.5 * shortest_interval_s(fit.observations);
  return (unread || lacking) && std::ranges::any_of(spin->alternatives_radps, [&](double omega) {
           return std::abs(omega) <= spin->window_radps;
         });
}

/// Whether equators of a leg were left out since they fit no spin of the others: before one by one is looked
/// for a bad measurement, of which two mask each other.
bool leave_out_equators(ShotFit& fit) {
  const auto searches = spin_search(fit);
  bool any = false;
  for (std::size_t leg = 0; leg < 2; ++leg) {
    const auto& spin = fit.spin[leg];
    const std::vector<EquatorReading>& readings = fit.equators[leg];
    if (!spin || std::ssize(readings) < kMinForOutlier ||
        equators_agree(readings, *spin, kUsualEquatorSd_rad))
      continue;
    for (const std::size_t i :
         outside_consensus(stretched(readings, spin->time_s, searches[leg].decay_per_s), spin->window_radps,
                           kUsualEquatorSd_rad, kFalseAlarms / 3.0)) {
      fit.observations.images[readings[i].index].use_equator = false;
      any = true;
    }
  }
  if (any) fit_once(fit);
  return any;
}

/// The lift of a wrong spin bends the path away from good images: where the spin may be another, only what
/// fits no lift is an outlier.
Contradiction leave_out_misfits(ShotFit& fit) {
  const Contradiction equators = leave_out_equators(fit) ? Contradiction::clear : Contradiction::none;
  const auto fit_again = [&fit] { fit_once(fit); };
  const bool closed = !fit.spins_open && std::ranges::any_of(fit.spin, [](const auto& spin) {
    return spin && !spin->alternatives_radps.empty();
  });
  if (!closed) return std::max(reject_outliers(fit, fit_again), equators);
  const std::vector<Observation> images = fit.observations.images;
  if (reject_outliers(fit, fit_again) == Contradiction::none) return equators;
  fit.observations.images = images;
  fit.spins_open = true;
  fit_once(fit);
  const Contradiction rejected = reject_outliers(fit, fit_again);
  fit.spins_open = false;
  fit_once(fit);
  return std::max(rejected, equators);
}

/// Mirrors where the legs as fitted, without the images left out, say otherwise than the first and last image
/// did.
void orient(ShotFit& fit) {
  const std::size_t leg = fit.joint.legs[0].fitted ? 0 : 1;
  if (fit.joint.degenerate() || !fit.joint.legs[leg].fitted) return;
  const double* way = &fit.joint.unknowns[kLegStart[leg] + 2];
  const bool mirrored = fit.observations.surface.mirrored;
  if (travels_left({mirrored ? -way[0] : way[0], way[1]}) == mirrored) return;
  mirror(fit.observations);
  fit_once(fit);
}

}  // namespace

/// The bounce adds no energy: v^2 + alpha (R omega)^2 does not grow, alpha being half or more.
std::array<SpinSearch, 2> spin_search(const ShotFit& fit) {
  const Observations& all = fit.observations;
  const double interval_s = shortest_interval_s(all);
  const double radius_m = all.ball.radius_m();
  const std::array<double, 2> speed_mps{mean_speed_mps(all, 0), mean_speed_mps(all, 1)};
  const double faster_mps = std::max(speed_mps[0], speed_mps[1]);
  const double fastest_mps = all.fastest_spin_radps() * radius_m;
  const double rebound_mps = std::hypot(fastest_mps, std::numbers::sqrt2 * faster_mps);
  const double possible_mps = all.stated_fastest_radps ? 0.0 : kTearingRim_mps;
  // A photograph in which the spin would fade away shows no ball in flight, and exponentials that overflow.
  const double longest_m = faster_mps * (all.images.empty() ? 0.0 : all.images.back().time_s);
  const bool decays = fit.spin_decay_per_m * longest_m < 1.0;
  const double decay = decays ? fit.spin_decay_per_m : 0.0;
  const double sd = decays ? fit.spin_decay_sd_per_m : 0.0;
  const auto search = [&](double rim_mps, double speed) {
    return SpinSearch{interval_s, rim_mps / radius_m, decay * speed, sd * speed, possible_mps / radius_m};
  };
  return {search(fastest_mps, speed_mps[0]), search(rebound_mps, speed_mps[1])};
}

std::vector<OtherSpin> faster_spins(const ShotFit& fit, std::size_t leg) {
  if (!fit.spin[leg]) return {};
  std::vector<EquatorReading> left_out;
  read_equators(fit, leg, false, left_out);
  return faster_spins(fit.equators[leg], left_out, spin_search(fit)[leg], *fit.spin[leg]);
}

void refit(ShotFit& fit, flight::Effects effects) {
  fit.effects = effects;
  fit.air = flight::aerodynamics(fit.observations.ball, fit.observations.air_density_kgpm3, effects,
                                 fit.observations.air_law);
  fit_once(fit);
}

ShotFit fit_shot(Observations observations, FitOptions options, FlagSet& flags) {
  ShotFit fit;
  fit.observations = std::move(observations);
  fit.equator_seen.reserve(fit.observations.images.size());
  for (const Observation& o : fit.observations.images) fit.equator_seen.push_back(o.use_equator);
  fit.spins_open = options.spins_open;
  if (options.effects.drag) {
    const double density = fit.observations.air_density_kgpm3 / flight::kAirDensity_kgpm3;
    fit.spin_decay_per_m = fit.observations.air_law.spin_decay_per_m * density;
    fit.spin_decay_sd_per_m = fit.observations.air_law.spin_decay_sd_per_m * density;
  }
  refit(fit, options.effects);
  if (options.reject_outliers && leave_out_misfits(fit) == Contradiction::clear)
    flags.set(Flag::outlier_image);
  orient(fit);
  for (std::size_t leg = 0; leg < 2; ++leg) {
    if (aliased(fit, leg)) flags.set(Flag::spin_aliased);
  }
  if (any_estimated(fit.observations)) flags.set(Flag::sd_from_residuals);
  return fit;
}

}  // namespace strobe::reduction
