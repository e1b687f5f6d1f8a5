// Limits that several steps judge by. Constants.
#pragma once

namespace strobe::commission {

/// A deviation that is not chance: two-sided, of a normal, 6e-5.
inline constexpr double kCertain_sd = 4.0;
/// Of the scale over the whole width or height: speeds of either leg are then off by a quarter of it.
inline constexpr double kMaxSlope = 0.006;

}  // namespace strobe::commission
