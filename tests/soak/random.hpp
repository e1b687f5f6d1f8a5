// Seeded draws of the virtual lab: one stream per run, so that a seed repeats it on any machine.
// SplitMix64. Plain value; one thread's.
#pragma once

#include <cmath>
#include <cstdint>

#include "common/units/time.hpp"
#include "sim/random/draws.hpp"

namespace strobe::soak {

class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}

  std::uint64_t bits() {
    const std::uint64_t drawn = sim::hash64(state_);
    state_ += sim::kSplitMixStep;
    return drawn;
  }
  /// Uniform in [0, 1).
  double uniform() { return static_cast<double>(bits() >> 11) * 0x1p-53; }
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  /// Uniform in the logarithm; both positive.
  double log_uniform(double low, double high) { return low * std::pow(high / low, uniform()); }
  bool chance(double probability) { return uniform() < probability; }
  /// Uniform in low ... high, both included.
  int integer(int low, int high) {
    return low + static_cast<int>(bits() % static_cast<std::uint64_t>(high - low + 1));
  }
  Duration between(Duration low, Duration high) {
    return nanoseconds(low.count() + std::llround(uniform() * static_cast<double>((high - low).count())));
  }
  /// A positive random number, for ids and tokens.
  std::int64_t id() { return static_cast<std::int64_t>(bits() >> 1) | 1; }

 private:
  std::uint64_t state_;
};

/// Independent streams from one seed.
constexpr std::uint64_t mixed(std::uint64_t seed, std::uint64_t stream) {
  return sim::hash64(seed * sim::kSplitMixStep + stream * 0xd1b54a32d192ed03U + 0x632be59bd9b4e019U -
                     sim::kSplitMixStep);
}

}  // namespace strobe::soak
