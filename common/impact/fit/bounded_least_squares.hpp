// Nonlinear least squares within bounds: Levenberg-Marquardt (J. Moré, The Levenberg-Marquardt algorithm,
// 1978) with an active set of bounds, steps by Householder QR with column pivoting, from several starts; for
// residuals that are continuous but have kinks. Pure; deterministic; thread-safe; allocates.
#pragma once

#include <Eigen/Dense>
#include <array>
#include <functional>
#include <optional>
#include <string_view>
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

/// The Jacobian, where the problem has no derivatives by finite differences: central, or three-point
/// one-sided within a step of a bound. About 1e-10 relative where the residuals are smooth and in full double
/// precision.
Eigen::MatrixXd jacobian(const LeastSquaresProblem& problem, const Eigen::VectorXd& at);

/// Why a search stopped.
enum class Termination {
  tolerance,          ///< no step reduces the sum of squares by more than the tolerance
  no_free_parameter,  ///< there is none, or at each one's bound the descent points out of it
  damping_limit,      ///< no step reduces the sum of squares, however short
  iteration_limit,    ///< after 200 iterations steps still did
  not_finite,         ///< the residuals at the start are not finite
};

constexpr std::string_view name(Termination termination) {
  constexpr std::array<std::string_view, 5> names{"tolerance", "no free parameter", "damping limit",
                                                  "iteration limit", "not finite"};
  return names[static_cast<std::size_t>(termination)];
}

/// Whether the parameters are a local minimum as far as numbers tell.
constexpr bool converged(Termination t) {
  return t != Termination::iteration_limit && t != Termination::not_finite;
}

struct LeastSquaresResult {
  Eigen::VectorXd parameters;
  double sum_of_squares = 0.0;
  Termination termination = Termination::iteration_limit;
  int iterations = 0;  ///< Jacobians evaluated by the last run
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

// The covariance of a least squares fit from its residuals, that holds whatever their variances and however
// those of a cluster are correlated: the cluster-robust sandwich with the bias reduction CR2, and for each
// parameter the degrees of freedom of Student's t (Satterthwaite), which are few where few clusters determine
// it. Sources: R. Bell and D. McCaffrey, Survey Methodology 28, 2002; J. Pustejovsky and E. Tipton, Journal
// of Business & Economic Statistics 36, 2018. CR2 with clusters of one residual is HC2. Pure; thread-safe;
// allocates.

struct ClusteredCovariance {
  Eigen::MatrixXd covariance;
  Eigen::VectorXd degrees_of_freedom;  ///< of each parameter's variance, 1 or more
};

/// Of a Jacobian of full rank and the residuals, both weighted, alike and independent but for the clusters'
/// own errors. `clusters`: for each its rows; every row is in one cluster.
ClusteredCovariance clustered_covariance(const Eigen::MatrixXd& jacobian, const Eigen::VectorXd& residuals,
                                         const std::vector<std::vector<Eigen::Index>>& clusters);

/// A variance of fewer degrees of freedom has itself an sd above half of it: by chance it may be far too
/// small.
inline constexpr double kFewDegrees = 8.0;

/// What a sum of squares of residuals of unit variance stays below once in fifty by chance; 0 without degrees
/// of freedom.
double least_likely_chi2(double degrees_of_freedom);

/// Least share of the common variance that a robust one of so many degrees of freedom is taken to be: where
/// they are few all of it, else what would not be reached once in fifty were the residuals like all.
double least_robust_share(double degrees_of_freedom);

/// The rows of residuals in pairs, vx and spin of each observation, by the clusters of observations.
std::vector<std::vector<Eigen::Index>> rows_of_pairs(const std::vector<std::vector<std::size_t>>& clusters);

}  // namespace strobe::impact
