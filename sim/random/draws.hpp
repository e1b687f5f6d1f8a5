// Seeded random draws that do not depend on the order in which things happen: each purpose of each shot has a
// stream of its own. Counter-based with an own normal
// transform (Box and Muller 1958), since std::normal_distribution differs between standard libraries.
// Plain values: thread-safe per object, no allocation.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "sim/random/hash.hpp"

namespace strobe::sim {

/// Purpose of a draw. The values determine what a seed draws: append, never renumber.
enum class Purpose : std::uint64_t {
  machine = 1,
  bounce,
  lamp_a,
  lamp_b,
  shutter,
  gate,
  tablet,
  off_plane,
  appearance,  ///< of the photograph: ball, lamps, background
  flash_power,
};

/// No normal draw is farther from its mean than this many standard deviations (a share of 2e-9 would be), so
/// that what a shot can do has a bound.
inline constexpr double kLargestNormal = 6.0;

class Draws {
 public:
  /// The stream of `purpose` in the `shot`-th exposure (1-based) of a run seeded with `seed`.
  Draws(std::uint64_t seed, Purpose purpose, std::uint64_t shot)
      : key_(hash64(hash64(hash64(seed) + static_cast<std::uint64_t>(purpose)) + shot)) {}

  /// Uniform in (0, 1).
  double uniform() {
    const std::uint64_t bits = hash64(key_ + kSplitMixStep * ++count_) >> 11;
    return (static_cast<double>(bits) + 0.5) * 0x1p-53;
  }

  /// Standard normal, within ±kLargestNormal; always takes two uniforms, so that later draws do not depend on
  /// earlier choices.
  double normal() {
    const double radius = std::sqrt(-2.0 * std::log(uniform()));
    return std::clamp(radius * std::cos(2.0 * std::numbers::pi * uniform()), -kLargestNormal, kLargestNormal);
  }
  /// Without a spread the draw is taken but not computed.
  double normal(double mean, double sd) {
    if (sd != 0.0) return mean + sd * normal();
    count_ += 2;
    return mean;
  }

 private:
  std::uint64_t key_;
  std::uint64_t count_ = 0;
};

}  // namespace strobe::sim
