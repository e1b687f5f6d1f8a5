// Court pace rating of the International Tennis Federation, test methods ITF CS 01/02.
// Pure functions; thread-safe, real-time safe.
#pragma once

#include <cmath>

#include "common/units/angles.hpp"

namespace strobe::reduction {

/// Points for each 1 of friction and of restitution less.
inline constexpr double kFrictionPoints = 100.0;
inline constexpr double kRestitutionPoints = 150.0;

/// CPR = 100 (1 - mu) + 150 (0.81 - e_T), with e referred to 23 degrees Celsius: e_T = e + 0.003 (23 - T).
/// mu: impulse ratio; e: normal restitution. Also for dual numbers.
template <typename T>
T court_pace_rating(const T& e, const T& mu, double temperature_c) {
  const T e_23 = e + 0.003 * (23.0 - temperature_c);
  return kFrictionPoints * (1.0 - mu) + kRestitutionPoints * (0.81 - e_23);
}

/// The limits of the method: 30 +- 2 m/s, 16 +- 2 degrees, at most 3 revolutions a second. A rating of any
/// other shot is indicative only.
inline bool meets_court_pace_limits(double speed_mps, double theta_in_deg, double omega_radps) {
  return std::abs(speed_mps - 30.0) <= 2.0 && std::abs(theta_in_deg + 16.0) <= 2.0 &&
         std::abs(omega_radps) <= 3.0 * 2.0 * kPi;
}

}  // namespace strobe::reduction
