// The covariance of a least squares fit from its residuals, that holds whatever their variances and however those of a
// cluster are correlated: the cluster-robust sandwich with the bias reduction CR2, and for each parameter the degrees of
// freedom of Student's t (Satterthwaite), which are few where few clusters determine it.
// Sources: R. Bell and D. McCaffrey, Survey Methodology 28, 2002; J. Pustejovsky and E. Tipton, Journal of Business &
// Economic Statistics 36, 2018. CR2 with clusters of one residual is HC2. Pure; thread-safe; allocates.
#pragma once

#include <Eigen/Dense>
#include <vector>

namespace strobe::impact {

struct ClusteredCovariance {
  Eigen::MatrixXd covariance;
  Eigen::VectorXd degrees_of_freedom;  ///< of each parameter's variance, 1 or more
};

/// Of a Jacobian of full rank and the residuals, both weighted, alike and independent but for the clusters' own errors.
/// `clusters`: for each its rows; every row is in one cluster.
ClusteredCovariance clustered_covariance(const Eigen::MatrixXd& jacobian, const Eigen::VectorXd& residuals,
                                         const std::vector<std::vector<Eigen::Index>>& clusters);

/// A variance of fewer degrees of freedom has itself an sd above half of it: by chance it may be far too small.
inline constexpr double kFewDegrees = 8.0;

/// Least share of the common variance that a robust one of so many degrees of freedom is taken to be: where they are few
/// all of it, else what would not be reached once in fifty were the residuals like all.
double least_robust_share(double degrees_of_freedom);

/// The rows of residuals in pairs, vx and spin of each observation, by the clusters of observations.
std::vector<std::vector<Eigen::Index>> rows_of_pairs(const std::vector<std::vector<std::size_t>>& clusters);

}  // namespace strobe::impact
