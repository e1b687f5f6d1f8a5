// Seeded noise that any thread can compute anywhere: hashes of integers, smooth noise between them. Pure
// functions, thread-safe, no allocation.
#pragma once

#include <cmath>
#include <cstdint>

#include "sim/random/hash.hpp"

namespace strobe::sim {

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
