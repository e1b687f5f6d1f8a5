// Importance sampling, with Pareto smoothed weights: the largest weights are replaced by the quantiles of a
// generalized Pareto distribution fitted to them, whose shape k tells whether importance sampling can be
// trusted (A. Vehtari, D. Simpson, A. Gelman, Y. Yao and J. Gabry, Pareto smoothed importance sampling, 2015;
// the fit after J. Zhang and M. Stephens, Technometrics 51, 2009). Pure; thread-safe; allocates.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "common/sampling/sample.hpp"

namespace strobe::sampling {

/// Above it sums over the sample may be far off, however many draws there are.
inline constexpr double kMaxParetoShape = 0.7;

struct ParetoTail {
  double shape = 0.0;  ///< k
  double scale = 0.0;
};

/// Of 5 or more excesses above a threshold, ascending, positive. The shape is drawn to 1/2 by as much as 10
/// excesses.
ParetoTail fit_pareto_tail(const std::vector<double>& excesses);

struct SmoothedWeights {
  Eigen::VectorXd weights;  ///< with the sum 1
  double shape = 0.0;       ///< infinite where there are too few weights to tell (fewer than 25)
};

/// Of the logarithms of the weights, up to a constant; -infinity for a weight of 0.
SmoothedWeights smoothed_weights(const Eigen::VectorXd& log_weights);

// Importance sampling from a multivariate t distribution, with smoothed weights, the
// proposal fitted to the weighted sample and drawn from again where it does not match the density well enough
// (O. Cappé, A. Guillin, J. Marin and C. Robert, Population Monte Carlo, 2004). Deterministic for a seed;
// thread-safe; allocates.

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
