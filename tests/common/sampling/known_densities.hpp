// Densities whose moments are known exactly, to hold samplers against. Pure; thread-safe.
#pragma once

#include <Eigen/Dense>
#include <cmath>

#include "common/sampling/sample.hpp"

namespace strobe::testing {

/// Normal of mean (1, -2, 3), sds 1, 10 and 0.1, the first two correlated by 0.99.
struct CorrelatedNormal {
  Eigen::Vector3d mean{1.0, -2.0, 3.0};
  Eigen::Matrix3d covariance{{1.0, 9.9, 0.0}, {9.9, 100.0, 0.0}, {0.0, 0.0, 0.01}};

  sampling::LogDensity density() const {
    const Eigen::Matrix3d precision = covariance.inverse();
    return [centre = mean, precision](const Eigen::VectorXd& x) {
      const Eigen::Vector3d away = x - centre;
      return -0.5 * away.dot(precision * away);
    };
  }
};

/// Haario's banana: x normal of sd 2, y = z + b(x² - 4) with z standard normal. Its means are 0, its variances 4 and 1 +
/// 2·b²·4², its covariance 0.
struct Banana {
  double b = 0.5;
  double variance_y() const { return 1.0 + 32.0 * b * b; }

  sampling::LogDensity density() const {
    return [bend = b](const Eigen::VectorXd& x) {
      const double z = x[1] - bend * (x[0] * x[0] - 4.0);
      return -0.5 * (x[0] * x[0] / 4.0 + z * z);
    };
  }
};

/// Four and a half sds of a mean of so many independent draws: one such check in a hundred thousand fails by chance.
inline double mean_tolerance(double variance, double effective_size) {
  return 4.5 * std::sqrt(variance / effective_size);
}

}  // namespace strobe::testing
