// Importance sampling from a multivariate t distribution, with Pareto smoothed weights (pareto_tail.hpp), the proposal
// fitted to the weighted sample and drawn from again where it does not match the density well enough (O. Cappé, A.
// Guillin, J. Marin and C. Robert, Population Monte Carlo, 2004). Deterministic for a seed; thread-safe; allocates.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "common/sampling/sample.hpp"

namespace strobe::sampling {

struct ImportanceOptions {
  std::uint64_t seed = 1;
  int draws = 2000;            ///< of a round, 50 or more
  int rounds = 4;              ///< at most
  double least_size = 400.0;   ///< effective draws that end the rounds
  int degrees_of_freedom = 6;  ///< of the proposal
  Progress progress{};
};

struct ImportanceSample {
  Sample sample;  ///< of the round with the most effective draws
  double pareto_shape = 0.0;
  int rounds = 0;
  int evaluations = 0;

  /// Whether its moments and quantiles can be trusted.
  bool good(double least_size) const;
};

/// `covariance` is positive definite.
ImportanceSample importance_sample(const LogDensity& density, const Eigen::VectorXd& centre,
                                   const Eigen::MatrixXd& covariance, const ImportanceOptions& options);

}  // namespace strobe::sampling
