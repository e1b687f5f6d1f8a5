// Normal random numbers that are the same with every compiler and library. Single-threaded; does not allocate.
#pragma once

#include <Eigen/Core>
#include <boost/math/special_functions/erf.hpp>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>

namespace strobe::sampling {

class RandomNumbers {
 public:
  explicit RandomNumbers(std::uint64_t seed) : source_(seed) {}

  /// Within (0, 1), in steps of 2^-53.
  double uniform() { return (static_cast<double>(source_() >> 11U) + 0.5) * 0x1p-53; }
  /// Of mean 0 and variance 1, by the inverse of the distribution.
  double normal() { return -std::numbers::sqrt2 * boost::math::erfc_inv(2.0 * uniform()); }
  Eigen::VectorXd normals(Eigen::Index count) {
    Eigen::VectorXd out(count);
    for (double& x : out) x = normal();
    return out;
  }
  /// Sum of so many squares of normal numbers.
  double chi_squared(int degrees_of_freedom) {
    double sum = 0.0;
    for (int i = 0; i < degrees_of_freedom; ++i) {
      const double x = normal();
      sum += x * x;
    }
    return sum;
  }

 private:
  std::mt19937_64 source_;
};

}  // namespace strobe::sampling
