// Pareto smoothed importance weights: the largest weights are replaced by the quantiles of a generalized Pareto
// distribution fitted to them, whose shape k tells whether importance sampling can be trusted (A. Vehtari, D. Simpson, A.
// Gelman, Y. Yao and J. Gabry, Pareto smoothed importance sampling, 2015; the fit after J. Zhang and M. Stephens,
// Technometrics 51, 2009). Pure; thread-safe; allocates.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace strobe::sampling {

/// Above it sums over the sample may be far off, however many draws there are.
inline constexpr double kMaxParetoShape = 0.7;

struct ParetoTail {
  double shape = 0.0;  ///< k
  double scale = 0.0;
};

/// Of 5 or more excesses above a threshold, ascending, positive. The shape is drawn to 1/2 by as much as 10 excesses.
ParetoTail fit_pareto_tail(const std::vector<double>& excesses);

struct SmoothedWeights {
  Eigen::VectorXd weights;  ///< with the sum 1
  double shape = 0.0;       ///< infinite where there are too few weights to tell (fewer than 25)
};

/// Of the logarithms of the weights, up to a constant; -infinity for a weight of 0.
SmoothedWeights smoothed_weights(const Eigen::VectorXd& log_weights);

}  // namespace strobe::sampling
