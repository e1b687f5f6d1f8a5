// A weighted sample of a distribution: moments, quantiles and how many independent draws it is worth. Pure; thread-safe;
// allocates.
#pragma once

#include <Eigen/Core>
#include <functional>
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

}  // namespace strobe::sampling
