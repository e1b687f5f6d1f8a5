// The posterior of the contact mechanics' coefficients, in the coordinates of coefficient_prior.hpp, and its Laplace
// approximation at the mode: the normal, or t, distribution with the curvature there.
//
// With U the weighted sum of squares over the residuals' variance plus that of the prior, the density is exp(-U/2) where the
// variance is stated. Where the fit tells the variance it is integrated over it, a t of the fit's degrees of freedom nu:
// (1 + (U - U_least)/nu)^(-(nu + p)/2). With CovarianceScale::clustered the residuals need not be alike nor independent: U is
// taken at mode + C·(x - mode), C such that the curvature is that of the cluster-robust covariance (R. Chandler and S. Bate,
// Biometrika 94, 2007; M. Ribatet, D. Cooley and A. Davison, Statistica Sinica 22, 2012). Deterministic; thread-safe;
// allocates.
#pragma once

#include "common/impact/fit/fitter.hpp"

namespace strobe::impact {

class ContactPosterior {
 public:
  /// Of a fit at its least, with free parameters; must outlive this. The weights stay as they are there.
  explicit ContactPosterior(const Fitter& least);

  const Eigen::VectorXd& mode() const { return mode_; }
  /// Of the Laplace approximation: the scale matrix of a t distribution with degrees_of_freedom().
  const Eigen::MatrixXd& scale() const { return scale_; }
  double degrees_of_freedom() const { return freedom_; }
  /// Of each parameter's own Student's t where CovarianceScale::clustered says so; the scale allows for it at 95 %.
  const Eigen::VectorXd& own_degrees_of_freedom() const { return own_freedom_; }
  /// Up to a constant; -infinity where the contact cannot be computed.
  double log_density(const Eigen::VectorXd& coordinates) const;

 private:
  void find_scale(const Eigen::MatrixXd& jacobian, const Eigen::VectorXd& residuals);
  void adjust(const Eigen::MatrixXd& information);

  const Fitter& least_;
  Eigen::VectorXd mode_;
  Eigen::MatrixXd scale_;
  Eigen::VectorXd own_freedom_;
  Eigen::MatrixXd adjustment_;  ///< C; empty: the identity
  double freedom_ = 0.0;
  double least_squares_ = 0.0;
};

}  // namespace strobe::impact
