// A leg where it meets the surface, with derivatives by everything it hangs on. Part of the reduction, not of its
// interface. Pure; thread-safe.
#pragma once

#include <optional>

#include "common/reduction/dual.hpp"
#include "common/reduction/shot_fit.hpp"

namespace strobe::reduction {

// Variables of the derivatives: the joint fit's unknowns, both spins, the ball's diameter, the spin's decay, and the
// errors of the air.
inline constexpr std::size_t kSpin[2] = {kJointCount, kJointCount + 1};
inline constexpr std::size_t kDiameter = kJointCount + 2;
inline constexpr std::size_t kDecay = kJointCount + 3;
inline constexpr std::size_t kAir = kJointCount + 4;  // the first of AirErrors
using Number = Dual<kAir + kAirErrorCount>;

/// A leg where its centre is one radius above the surface, in the surface's axes.
struct SurfaceCrossing {
  Number time_s;
  Number x_m;
  Number vx_mps;
  Number vy_mps;
};

/// The ball's, half of its diameter.
Number radius(const ShotFit& fit);

/// Of one leg about its origin of time in the surface's axes; the height is less a radius.
flight::Flight flight_of(const ShotFit& fit, std::size_t leg);

/// Returns nullopt if the leg is not fitted, or does not meet the surface in its direction.
std::optional<SurfaceCrossing> crossing(const ShotFit& fit, std::size_t leg);

}  // namespace strobe::reduction
