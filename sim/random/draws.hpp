// SplitMix64 (Steele et al. 2014). Pure; thread-safe; no allocation.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace strobe::sim {

inline constexpr std::uint64_t kSplitMixStep = 0x9e3779b97f4a7c15U;

/// Its output for the state z; the next state is z + kSplitMixStep.
constexpr std::uint64_t hash64(std::uint64_t z) {
  z += kSplitMixStep;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9U;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebU;
  return z ^ (z >> 31);
}

// Seeded random draws that do not depend on the order in which things happen: each purpose of each shot has a
// stream of its own. Counter-based with an own normal
// transform (Box and Muller 1958), since std::normal_distribution differs between standard libraries.
// Plain values: thread-safe per object, no allocation.

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
  camera_link,   ///< what it loses
  out_of_plane,  ///< direction of travel and spins
  tablet_tilt,
  flash_sequencer,
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

// Seeded noise that any thread can compute anywhere: hashes of integers, smooth noise between them. Pure
// functions, thread-safe, no allocation.

/// Value noise: at lattice points uniform in ±1, smooth between them.
class ValueNoise {
 public:
  explicit ValueNoise(std::uint64_t seed) : seed_(hash64(seed)) {}

  double at(double x, double y, double z) const {
    const double fx = std::floor(x), fy = std::floor(y), fz = std::floor(z);
    const auto ix = static_cast<std::int64_t>(fx), iy = static_cast<std::int64_t>(fy);
    const auto iz = static_cast<std::int64_t>(fz);
    const double u = smooth(x - fx), v = smooth(y - fy), w = smooth(z - fz);
    const auto plane = [&](std::int64_t k) {
      const double below = mix(lattice(ix, iy, k), lattice(ix + 1, iy, k), u);
      const double above = mix(lattice(ix, iy + 1, k), lattice(ix + 1, iy + 1, k), u);
      return mix(below, above, v);
    };
    return mix(plane(iz), plane(iz + 1), w);
  }
  double at(double x, double y) const { return at(x, y, 0.0); }

 private:
  static double smooth(double t) { return t * t * (3.0 - 2.0 * t); }
  static double mix(double a, double b, double t) { return a + t * (b - a); }
  double lattice(std::int64_t x, std::int64_t y, std::int64_t z) const {
    const auto key = static_cast<std::uint64_t>(x) * 0x8da6b343U +
                     static_cast<std::uint64_t>(y) * 0xd8163841U +
                     static_cast<std::uint64_t>(z) * 0xcb1ab31fU;
    return static_cast<double>(hash64(seed_ ^ key) >> 11) * 0x1p-52 - 1.0;
  }

  std::uint64_t seed_;
};

}  // namespace strobe::sim
