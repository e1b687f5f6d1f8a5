// Angles: radians inside, degrees in input and output; differences of directions modulo one or half a turn.
// Pure functions; thread-safe, real-time safe.
#pragma once

#include <cmath>
#include <numbers>

namespace strobe {

inline constexpr double kPi = std::numbers::pi;

constexpr double radians(double degrees) { return degrees * (kPi / 180.0); }
constexpr double degrees(double radians) { return radians * (180.0 / kPi); }

namespace detail {

/// pi less its nearest double, kPi.
inline constexpr double kPiRest = 1.2246467991473532e-16;

/// Above this the angle's own spacing exceeds 1e-8 rad, and kPi alone serves.
inline constexpr double kPreciseUpTo_rad = 1e8;

/// The argument less n times `share`·pi, n whole: with pi in two parts and products that do not round, so
/// that an angle of many turns loses no more digits than its own last one.
inline double less_multiples_of_pi(double angle_rad, double share) {
  const double period = share * kPi;
  if (!(std::abs(angle_rad) <= kPreciseUpTo_rad)) return std::remainder(angle_rad, period);
  const double n = std::nearbyint(angle_rad / period);
  const double rest = std::fma(-n, share * kPiRest, std::fma(-n, period, angle_rad));
  if (std::abs(rest) <= 0.5 * period) return rest;
  // Half-way between two multiples the quotient's rounding may have named the wrong one.
  const double other = n + std::copysign(1.0, rest);
  return std::fma(-other, share * kPiRest, std::fma(-other, period, angle_rad));
}

}  // namespace detail

/// The angle between two directions of a line, in [-pi/2, pi/2]: the argument less the nearest multiple of
/// pi, to 1e-15 of the result for |angle| <= 1e8 rad. Valid: finite.
inline double wrap_half_turn(double angle_rad) { return detail::less_multiples_of_pi(angle_rad, 1.0); }

/// The argument less the nearest multiple of 2 pi, in [-pi, pi], as exact as wrap_half_turn. Valid: finite.
inline double wrap_turn(double angle_rad) { return detail::less_multiples_of_pi(angle_rad, 2.0); }

}  // namespace strobe
