// Angles: radians inside, degrees at the edge; lines, which are the same after half a turn.
// Pure functions; thread-safe, real-time safe.
#pragma once

#include <cmath>
#include <numbers>

namespace strobe {

inline constexpr double kPi = std::numbers::pi;

constexpr double radians(double degrees) { return degrees * (kPi / 180.0); }
constexpr double degrees(double radians) { return radians * (180.0 / kPi); }

/// The angle between two directions of a line, in [-pi/2, pi/2]: the argument less the nearest multiple of
/// pi.
inline double wrap_half_turn(double angle_rad) { return angle_rad - kPi * std::nearbyint(angle_rad / kPi); }

/// The argument less the nearest multiple of 2 pi, in [-pi, pi].
inline double wrap_turn(double angle_rad) {
  return angle_rad - 2.0 * kPi * std::nearbyint(angle_rad / (2.0 * kPi));
}

}  // namespace strobe
