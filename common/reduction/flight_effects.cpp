#include "common/reduction/flight_effects.hpp"

#include <algorithm>
#include <cmath>

#include "common/reduction/propagate.hpp"
#include "common/units/angles.hpp"

namespace strobe::reduction {
namespace {

struct LegChange {
  double velocity_mps = 0.0;
  double place_m = 0.0;
};

double longest_s(const ShotFit& fit, std::size_t leg, double crossing_s) {
  const LegTime& times = fit.joint.legs[leg];
  return std::max(std::abs(times.first_s - crossing_s), std::abs(times.last_s - crossing_s));
}

bool significant(const Readout& readout, const Quantities& change) {
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    if (!change[q] || *change[q] == 0.0) continue;
    if (!readout.sd[q] || *change[q] > kNegligibleShareOfSd * *readout.sd[q]) return true;
  }
  return false;
}

}  // namespace

Quantities change_bound(const Readout& readout, const ShotFit& fit, const Crossings& crossings,
                        const std::array<double, 2>& acceleration_mps2) {
  Quantities bound;
  LegChange legs[2];
  const auto leg = [&](std::size_t i, Quantity theta, Quantity vx, Quantity vy, Quantity v) {
    if (!crossings[i] || !readout.value[v]) return;
    const double time_s = longest_s(fit, i, *crossings[i]);
    legs[i] = {acceleration_mps2[i] * time_s, 0.5 * acceleration_mps2[i] * time_s * time_s};
    bound[vx] = bound[vy] = bound[v] = legs[i].velocity_mps;
    bound[theta] = degrees(legs[i].velocity_mps / *readout.value[v]);
  };
  leg(0, Quantity::theta_in_deg, Quantity::vx_td_mps, Quantity::vy_td_mps, Quantity::v_td_mps);
  leg(1, Quantity::theta_out_deg, Quantity::vx_lo_mps, Quantity::vy_lo_mps, Quantity::v_lo_mps);
  if (readout.value[Quantity::slip_lo_mps]) bound[Quantity::slip_lo_mps] = legs[1].velocity_mps;
  if (!readout.value[Quantity::e] || !readout.value[Quantity::mu]) return bound;
  const double vy_td = std::abs(*readout.value[Quantity::vy_td_mps]);
  const double vy_lo = std::abs(*readout.value[Quantity::vy_lo_mps]);
  const double e = (legs[1].velocity_mps + vy_lo / vy_td * legs[0].velocity_mps) / vy_td;
  const double mu = (legs[0].velocity_mps + legs[1].velocity_mps) *
                    (1.0 + std::abs(*readout.value[Quantity::mu])) / (vy_td + vy_lo);
  bound[Quantity::e] = e;
  bound[Quantity::mu] = mu;
  if (readout.value[Quantity::court_pace])
    bound[Quantity::court_pace] = kFrictionPoints * mu + kRestitutionPoints * e;
  if (!readout.value[Quantity::dwell_time_ms]) return bound;
  const double td_s = legs[0].place_m / vy_td;
  const double lo_s = legs[1].place_m / vy_lo;
  bound[Quantity::dwell_time_ms] = 1e3 * (td_s + lo_s);
  bound[Quantity::dwell_distance_cm] =
      1e2 * (legs[0].place_m + std::abs(*readout.value[Quantity::vx_td_mps]) * td_s + legs[1].place_m +
             std::abs(*readout.value[Quantity::vx_lo_mps]) * lo_s);
  return bound;
}

flight::Effects significant_effects(const Readout& readout, const ShotFit& fit, const Crossings& crossings,
                                    flight::Effects candidates) {
  std::array<double, 2> drag{};
  std::array<double, 2> lift{};
  constexpr Quantity kSpeed[2] = {Quantity::v_td_mps, Quantity::v_lo_mps};
  for (std::size_t leg = 0; leg < 2; ++leg) {
    if (!readout.value[kSpeed[leg]]) continue;
    double speed = *readout.value[kSpeed[leg]];
    // Of a ball that falls the launch is not the fastest.
    if (!fit.observations.has_surface())
      speed += fit.observations.gravity_mps2.norm() * fit.joint.legs[leg].span_s;
    drag[leg] = fit.air.drag_mps2(speed);
    if (fit.spin[leg]) lift[leg] = std::abs(fit.air.lift_mps2(speed, fit.spin[leg]->omega_radps));
    const AirError& error = fit.air_fit.prior[kLiftError[leg]];
    if (error.open) lift[leg] += speed * (std::abs(error.mean) + 2.0 * error.sd);
  }
  flight::Effects kept = candidates;
  kept.drag = kept.drag && significant(readout, change_bound(readout, fit, crossings, drag));
  kept.magnus = kept.magnus && significant(readout, change_bound(readout, fit, crossings, lift));
  return kept;
}

}  // namespace strobe::reduction
