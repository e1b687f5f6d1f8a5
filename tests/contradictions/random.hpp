// Draws of one shot, repeatable from its seed with every compiler and library. Plain value: thread-safe per object.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

#include "sim/random/draws.hpp"

namespace strobe::contradictions {

class Random {
 public:
  Random(std::uint64_t seed, std::uint64_t stream, std::uint64_t shot)
      : key_(sim::hash64(sim::hash64(sim::hash64(seed) + stream) + shot)) {}

  /// Uniform in (0, 1).
  double uniform() {
    const std::uint64_t bits = sim::hash64(key_ + sim::kSplitMixStep * ++count_) >> 11;
    return (static_cast<double>(bits) + 0.5) * 0x1p-53;
  }
  double within(double least, double most) { return least + (most - least) * uniform(); }
  /// Its logarithm is uniform. Both > 0.
  double logarithmic(double least, double most) { return least * std::pow(most / least, uniform()); }
  double sign() { return chance(0.5) ? 1.0 : -1.0; }
  bool chance(double probability) { return uniform() < probability; }
  /// One of 0 .. count - 1. count > 0.
  std::size_t index(std::size_t count) {
    return static_cast<std::size_t>(uniform() * static_cast<double>(count));
  }
  int integer(int least, int most) {
    return least + static_cast<int>(index(static_cast<std::size_t>(most - least + 1)));
  }

  /// Standard normal (Box and Muller 1958).
  double normal() {
    if (kept_) {
      kept_ = false;
      return kept_value_;
    }
    const double radius = std::sqrt(-2.0 * std::log(uniform()));
    const double angle = 2.0 * std::numbers::pi * uniform();
    kept_ = true;
    kept_value_ = radius * std::sin(angle);
    return radius * std::cos(angle);
  }
  /// Student's t with three degrees of freedom; its variance is 3.
  double student_3() {
    const double top = normal();
    const double a = normal(), b = normal(), c = normal();
    return top / std::sqrt((a * a + b * b + c * c) / 3.0);
  }

 private:
  std::uint64_t key_;
  std::uint64_t count_ = 0;
  bool kept_ = false;
  double kept_value_ = 0.0;
};

}  // namespace strobe::contradictions
