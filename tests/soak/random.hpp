// Seeded draws of the virtual lab: one stream per run, so that a seed repeats it on any machine.
// SplitMix64 (Steele et al. 2014). Plain value; one thread's.
#pragma once

#include <cmath>
#include <cstdint>

#include "common/units/time.hpp"

namespace strobe::soak {

class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}

  std::uint64_t bits() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15U);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9U;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebU;
    return z ^ (z >> 31);
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
  std::uint64_t z = seed * 0x9e3779b97f4a7c15U + stream * 0xd1b54a32d192ed03U + 0x632be59bd9b4e019U;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9U;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebU;
  return z ^ (z >> 31);
}

}  // namespace strobe::soak
