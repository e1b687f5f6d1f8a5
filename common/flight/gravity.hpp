// Gravity. Plain value; real-time safe.
#pragma once

namespace strobe::flight {

/// Standard acceleration of free fall (CGPM 1901), the only value of it.
inline constexpr double kStandardGravity_mps2 = 9.80665;

}  // namespace strobe::flight
