// What is known of any ball. Constants.
#pragma once

namespace strobe::digitize {

/// Of the ball's radius, and some more: the fastest shots compress a ball by .7.
inline constexpr double kMaxCompressionOfRadius = 0.85;

}  // namespace strobe::digitize
