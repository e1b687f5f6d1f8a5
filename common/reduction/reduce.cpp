#include "common/reduction/reduce.hpp"

#include <charconv>
#include <cmath>
#include <utility>

#include "common/reduction/legacy.hpp"
#include "common/reduction/propagate.hpp"
#include "common/reduction/shot_fit.hpp"

namespace strobe::reduction {
namespace {

/// From the frame, or from the session's record if that has a number there.
std::optional<double> temperature_c(const Frame& frame) {
  if (frame.temperature_c) return frame.temperature_c;
  const auto entry = frame.record.find("temperature_c");
  if (entry == frame.record.end()) return std::nullopt;
  const std::string& text = entry->second;
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

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
  if (count[0] == 2 || count[1] == 2) flags.set(Flag::no_redundancy);
}

Readout fitted_readout(const Frame& frame, Estimator estimator) {
  Readout readout;
  readout.shot_id = frame.shot_id;
  readout.record = frame.record;
  readout.method = estimator == Estimator::best ? "best" : "two-point";
  std::optional<Observations> observations = observe(frame, readout.flags);
  if (!observations) return readout;
  readout.mirrored = observations->levelling.mirrored;
  const bool best = estimator == Estimator::best;
  if (!best) {
    flag_redundancy(*observations, readout.flags);
    keep_nearest(*observations);
  }
  const ShotFit fit =
      fit_shot(std::move(*observations), {.gravity = best, .leave_out_outliers = best}, readout.flags);
  if (best) flag_redundancy(fit.observations, readout.flags);
  propagate(fit, temperature_c(frame), readout);
  return readout;
}

double chi_squared(const CentreResidual& r) {
  const double determinant = r.cov_xx * r.cov_yy - r.cov_xy * r.cov_xy;
  const Vec2 v = r.residual;
  return (r.cov_yy * v.x * v.x - 2.0 * r.cov_xy * v.x * v.y + r.cov_xx * v.y * v.y) / determinant;
}

}  // namespace

Result<Readout> reduce(const Frame& frame, Estimator estimator) {
  if (const auto complaint = invalid(frame)) return fail(*complaint);
  if (estimator == Estimator::legacy) return reduce_legacy(frame);
  return fitted_readout(frame, estimator);
}

Result<FlightFit> fit_flight(const Frame& frame) {
  if (const auto complaint = invalid(frame)) return fail(*complaint);
  FlagSet flags;
  std::optional<Observations> all = observe(frame, flags);
  if (!all) return fail("surface_px: the points do not span a line");
  all->levels[Noise::centre] = all->levels[Noise::surface] = all->levels[Noise::diameter] =
      1.0 / all->levelling.px_per_m;
  ShotFit fit;
  fit.joint = fit_joint(*all, all->gravity_mps2);
  fit.observations = std::move(*all);
  if (!fit.joint.legs[0].fitted || !fit.joint.legs[1].fitted) {
    return fail("images: a leg has fewer than two airborne images");
  }
  const auto contact = contact_values(fit);
  if (!contact) return fail("images: a leg does not meet the surface, or lift-off does not follow touchdown");
  FlightFit result;
  for (const Observation& o : fit.observations.images) {
    if (!o.use_centre) continue;
    result.chi_squared += chi_squared(centre_residual(fit.observations, fit.joint, o));
    result.degrees_of_freedom += 2;
  }
  result.degrees_of_freedom -= 8;  // position and velocity of two legs
  result.dwell_time_s = contact->dwell_time_s;
  result.dwell_distance_m = contact->dwell_distance_m;
  result.vx_td_mps = contact->vx_td_mps;
  result.vx_lo_mps = contact->vx_lo_mps;
  return result;
}

}  // namespace strobe::reduction
