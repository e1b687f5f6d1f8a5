// A weighted sample of a distribution: moments, quantiles and how many independent draws it is worth. Pure;
// thread-safe; allocates.
#pragma once

#include <Eigen/Core>
#include <boost/math/special_functions/erf.hpp>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <random>
#include <vector>

namespace strobe::sampling {

/// The logarithm of a density, up to a constant; -infinity where it is 0.
using LogDensity = std::function<double(const Eigen::VectorXd&)>;

/// Told the share that is done, 0…1; may be empty.
using Progress = std::function<void(double)>;

struct Sample {
  Eigen::MatrixXd points;   ///< one a column
  Eigen::VectorXd weights;  ///< of each column, with the sum 1

  Eigen::VectorXd mean() const;
  Eigen::MatrixXd covariance() const;
  /// Of one coordinate: values below which the weights are `levels`, each in (0, 1).
  std::vector<double> quantiles(Eigen::Index coordinate, const std::vector<double>& levels) const;
  /// Kish: the square of the weights' sum over the sum of their squares.
  double effective_size() const;
};

/// Equal weights.
Sample unweighted(Eigen::MatrixXd points);

// Normal random numbers that are the same with every compiler and library. Single-threaded; does not
// allocate.

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
