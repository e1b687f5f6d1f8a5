// Nonlinear least squares within bounds: Levenberg-Marquardt (J. Moré, The Levenberg-Marquardt algorithm,
// 1978) with an active set of bounds, steps by Householder QR with column pivoting, from several starts; for
// residuals that are continuous but have kinks. Pure; deterministic; thread-safe; allocates.
#pragma once

#include <Eigen/Dense>
#include <functional>
#include <optional>
#include <vector>

namespace strobe::impact {

struct LeastSquaresProblem {
  /// Residuals at parameters within the bounds; always of the same length.
  std::function<Eigen::VectorXd(const Eigen::VectorXd&)> residuals;
  /// Their derivatives, a column for each parameter; by finite differences where empty.
  std::function<Eigen::MatrixXd(const Eigen::VectorXd&)> derivatives{};
  Eigen::VectorXd lower;  ///< finite, below `upper`
  Eigen::VectorXd upper;
  /// > 0: a significant change of each parameter, for finite differences and searches.
  Eigen::VectorXd scale;
  /// Step of the finite differences over the larger of |parameter| and scale. The default, the cube root of
  /// the rounding error, is for residuals in full double precision; less accurate ones need wider steps.
  double difference_step = 6.0554544523933395e-6;
  /// Converged when a step reduces the sum of squares, or after a rejected step the linear model predicts to,
  /// by no more than this fraction of it. 0: by no more than rounding.
  double function_tolerance = 0.0;
};

/// The Jacobian, where the problem has no derivatives by finite differences: central, or three-point one-sided within a step of a bound. About 1e-10
/// relative where the residuals are smooth and in full double precision.
Eigen::MatrixXd jacobian(const LeastSquaresProblem& problem, const Eigen::VectorXd& at);

struct LeastSquaresResult {
  Eigen::VectorXd parameters;
  double sum_of_squares = 0.0;
  bool converged = false;  ///< false: stopped at the limit of 200 iterations
  int iterations = 0;      ///< Jacobians evaluated by the last run
};

/// Local minimum from one start (clamped to the bounds). Points whose residuals are infinite are avoided.
LeastSquaresResult levenberg_marquardt(const LeastSquaresProblem& problem, const Eigen::VectorXd& start);

/// Best local minimum from `first` and from those `tries` of the `candidates` that have the smallest sums,
/// followed by a search along the axes, which passes kinks where derivatives mislead. Ties go to the earlier
/// start.
LeastSquaresResult minimize(const LeastSquaresProblem& problem, const Eigen::VectorXd& first,
                            const std::vector<Eigen::VectorXd>& candidates, std::size_t tries);

/// Likewise for residuals without kinks: no search along the axes.
LeastSquaresResult minimize_smooth(const LeastSquaresProblem& problem, const Eigen::VectorXd& first,
                                   const std::vector<Eigen::VectorXd>& candidates, std::size_t tries);

/// (JᵀJ)⁻¹, the covariance for residuals of unit variance, by QR of J with its columns scaled to unit length.
/// Returns nullopt if J is rank-deficient: fewer rows than columns, a column that is zero or not finite, or
/// one that is, but for `rank_tolerance` of its length, a combination of others. 1e-13 accepts condition
/// numbers up to about 1e12 of the scaled columns; Jacobians by finite differences need 1e-8. A Jacobian
/// without columns gives an empty matrix.
std::optional<Eigen::MatrixXd> unscaled_covariance(const Eigen::MatrixXd& jacobian,
                                                   double rank_tolerance = 1e-13);

}  // namespace strobe::impact
