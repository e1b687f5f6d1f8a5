#include "common/reduction/map_errors.hpp"

#include <cmath>

namespace strobe::reduction {
namespace {

using Primary = std::array<std::optional<double>, kPrimaryCount>;

Primary primary(const Readout& readout, const Crossings& crossings) {
  const Quantities& v = readout.value;
  return {v[Quantity::vx_td_mps], v[Quantity::vy_td_mps], v[Quantity::omega_td_radps], crossings[0],
          v[Quantity::vx_lo_mps], v[Quantity::vy_lo_mps], v[Quantity::omega_lo_radps], crossings[1]};
}

void shift(Observations& all, const ObservedMapError& error) {
  for (std::size_t i = 0; i < all.images.size(); ++i) {
    all.images[i].centre_m += error.images[i].centre_m;
    all.images[i].diameter_m += error.images[i].diameter_m;
    all.images[i].equator_rad += error.images[i].equator_rad;
  }
  for (std::size_t i = 0; i < all.surface_m.size(); ++i) all.surface_m[i] += error.surface_m[i];
}

void add(const Quantities& variance, Readout& readout) {
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    if (readout.sd[q] && variance[q]) readout.sd[q] = std::hypot(*readout.sd[q], std::sqrt(*variance[q]));
  }
}

}  // namespace

void add_map_errors(const ShotFit& fit, const PropagationOptions& options, const Crossings& crossings,
                    Readout& readout) {
  Quantities variance;
  const Primary as_seen = primary(readout, crossings);
  const PropagationOptions numbers{options.temperature_c};
  for (const ObservedMapError& error : fit.observations.map_errors) {
    ShotFit moved = fit;
    shift(moved.observations, error);
    refit(moved, fit.effects);
    Readout other;
    const Crossings where = propagate(moved, numbers, other);
    for (std::size_t i = 0; i < kQuantityCount; ++i) {
      const auto q = static_cast<Quantity>(i);
      const double change = difference(other.value[q], readout.value[q]);
      variance[q] = variance[q].value_or(0.0) + change * change;
    }
    if (!readout.covariance) continue;
    const Primary now = primary(other, where);
    for (std::size_t i = 0; i < kPrimaryCount; ++i) {
      for (std::size_t k = 0; k < kPrimaryCount; ++k)
        (*readout.covariance)[i][k] += difference(now[i], as_seen[i]) * difference(now[k], as_seen[k]);
    }
  }
  add(variance, readout);
}

}  // namespace strobe::reduction
