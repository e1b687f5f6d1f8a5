// Nonlinear least squares within bounds: Levenberg-Marquardt steps by orthogonal factorization of the
// Jacobian (Householder QR with column pivoting, never the normal equations), from several starts, made for
// residuals that are continuous but have kinks. Pure; deterministic; thread-safe; allocates.
#pragma once

#include <Eigen/Dense>
#include <functional>
#include <optional>
#include <vector>

namespace strobe::impact {

struct LeastSquaresProblem {
  /// Residuals at a point within the bounds; always of the same length, finite.
  std::function<Eigen::VectorXd(const Eigen::VectorXd&)> residuals;
  Eigen::VectorXd lower;  ///< finite, below `upper`
  Eigen::VectorXd upper;
  /// > 0: a step of this much in each parameter matters; for differences and searches.
  Eigen::VectorXd scale;
  /// Step of the differences over the larger of |parameter| and scale. The default, the cube root of the
  /// rounding, is for residuals in full double precision; coarser ones need wider steps.
  double difference = 6.0554544523933395e-6;
  /// A descent ends where a step lessens the sum of squares, or after a vain one is to, by no more than this
  /// share of it. 0: by no more than rounding.
  double least_gain = 0.0;
};

/// Derivatives of the residuals by differences: central, or three-point one-sided within a step of a bound.
/// About 1e-10 relative where the residuals are smooth and in full double precision.
Eigen::MatrixXd jacobian(const LeastSquaresProblem& problem, const Eigen::VectorXd& at);

struct LeastSquaresResult {
  Eigen::VectorXd at;
  double sum_of_squares = 0.0;
  bool converged = false;  ///< false: stopped at the limit of 200 iterations
  int iterations = 0;      ///< Jacobians evaluated by the last descent
};

/// Local minimum from one start (moved into the bounds). Residuals that are infinite at some other point keep
/// the descent away from it.
LeastSquaresResult levenberg_marquardt(const LeastSquaresProblem& problem, const Eigen::VectorXd& start);

/// Best of the descents from `first` and from those `tries` of the `candidates` that have the smallest sums,
/// then a search along the axes, which passes kinks where derivatives mislead. Ties go to the earlier start.
LeastSquaresResult minimize(const LeastSquaresProblem& problem, const Eigen::VectorXd& first,
                            const std::vector<Eigen::VectorXd>& candidates, std::size_t tries);

/// Inverse of JᵀJ by QR of J with its columns scaled to unit length. Nothing if a column is zero or, but for
/// `dependence` of its length, a combination of others; 1e-13 tells condition numbers up to about 1e12 (of
/// the scaled columns) from dependence, derivatives by differences need 1e-8. Rows must be at least as many
/// as columns; a Jacobian without columns gives an empty matrix.
std::optional<Eigen::MatrixXd> inverse_gram(const Eigen::MatrixXd& jacobian, double dependence = 1e-13);

}  // namespace strobe::impact
