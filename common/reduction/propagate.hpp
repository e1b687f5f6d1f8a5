// From fitted unknowns to the readout's numbers and their standard deviations.
// Part of the reduction, not of its interface. Thread-safe.
#pragma once

#include <array>
#include <cmath>
#include <optional>

#include "common/reduction/readout.hpp"
#include "common/reduction/shot_fit.hpp"
#include "common/units/angles.hpp"

namespace strobe::reduction {

struct PropagationOptions {
  std::optional<double> temperature_c;  ///< for the court pace
  bool covariance = false;              ///< fill Readout::covariance
  bool by_time = false;                 ///< fill Readout::by_time
  /// Widen the sds of numbers with a divisor near zero, beyond the first order, and withhold those without an
  /// end: for the numbers that are told; what the fit decides goes by the first order.
  bool widened = false;
};

/// Touchdown and lift-off, where there is one, in the observations' time. [s]
using Crossings = std::array<std::optional<double>, 2>;

/// Fills value, sd, sd_systematic, regime and court pace, and sets too_few_images and degenerate_geometry.
/// Touchdown and lift-off are where the fitted flight has its centre one radius above the fitted line. Every
/// sd is first order (delta method) with exact derivatives, through the full covariance, which is held as a
/// triangular factor R: the variance of a number with gradient g is |R^-T g|^2.
Crossings propagate(const ShotFit& fit, const PropagationOptions& options, Readout& readout);

/// Whether PropagationOptions::widened would change anything: some velocity or speed is within 20 sd of zero.
/// The mean of the velocities across the surface is then no nearer to zero, in its sds, than both are.
bool may_lack_variance(const Numbers& numbers);

/// Court pace rating of the International Tennis Federation, test methods ITF CS 01/02: points for each 1 of
/// friction and of restitution less.
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
