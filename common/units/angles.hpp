// Angles: radians inside, degrees in input and output; directions modulo half a turn.
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

}  // namespace detail

/// The angle between two directions of a line, in [-pi/2, pi/2]: the argument less the nearest multiple of
/// pi, to 1e-15 of the result for |angle| <= 1e8 rad. Valid: finite.
inline double wrap_half_turn(double angle_rad) {
  if (!(std::abs(angle_rad) <= detail::kPreciseUpTo_rad)) return std::remainder(angle_rad, kPi);
  // With pi in two parts and products that do not round, an angle of many turns loses no more digits than
  // its own last one.
  const double n = std::nearbyint(angle_rad / kPi);
  const double rest = std::fma(-n, detail::kPiRest, std::fma(-n, kPi, angle_rad));
  if (std::abs(rest) <= 0.5 * kPi) return rest;
  // Half-way between two multiples the quotient's rounding may have named the wrong one.
  const double other = n + std::copysign(1.0, rest);
  return std::fma(-other, detail::kPiRest, std::fma(-other, kPi, angle_rad));
}

}  // namespace strobe
