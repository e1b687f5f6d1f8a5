#include "common/impact/fit/contact_posterior.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "common/impact/fit/clustered_covariance.hpp"
#include "common/statistics/distributions.hpp"

namespace strobe::impact {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

double t_quantile(double freedom) {
  return statistics::student_t_quantile(std::min(freedom, statistics::kAsGoodAsNormal),
                                        0.5 * (1.0 - kIntervalLevel));
}

}  // namespace

ContactPosterior::ContactPosterior(const Fitter& least) : least_(least), mode_(least.free_values()) {
  const VectorXd residuals = least.residuals_at(mode_);
  least_squares_ = residuals.squaredNorm();
  const bool stated = least.options().scale == CovarianceScale::stated;
  freedom_ = stated ? statistics::kAsGoodAsNormal : std::max(1, least.degrees_of_freedom_between());
  find_scale(jacobian(least.problem(), mode_), residuals);
}

/// The prior's rows have the variance that they state; only the data's are judged by their residuals.
void ContactPosterior::find_scale(const MatrixXd& jac, const VectorXd& residuals) {
  const Index n = mode_.size(), rows = jac.rows() - n;
  const MatrixXd information = jac.transpose() * jac / least_.variance();
  scale_ = information.llt().solve(MatrixXd::Identity(n, n));
  own_freedom_ = VectorXd::Constant(n, freedom_);
  if (least_.options().scale != CovarianceScale::clustered) return;
  const ClusteredCovariance robust = clustered_covariance(jac, residuals, rows_of_pairs(least_.clusters()));
  const MatrixXd from_prior = scale_ * jac.bottomRows(n).transpose() / least_.variance();
  MatrixXd both = robust.covariance + least_.variance() * from_prior * from_prior.transpose();
  if (both.llt().info() != Eigen::Success || rows < n) return;
  VectorXd stretch(n);
  for (Index k = 0; k < n; ++k) {
    const double degrees = robust.degrees_of_freedom[k];
    const double variance = std::max(both(k, k), least_robust_share(degrees) * scale_(k, k));
    if (degrees >= kFewDegrees || least_.scatters()) own_freedom_[k] = degrees;
    stretch[k] = std::sqrt(variance / both(k, k)) * t_quantile(own_freedom_[k]) / t_quantile(freedom_);
  }
  scale_ = stretch.asDiagonal() * both * stretch.asDiagonal();
  adjust(information);
}

/// With L the root of the information, C turns the sphere Lᵀ(x - mode) into that of the scale, by the symmetric root, which
/// turns least.
void ContactPosterior::adjust(const MatrixXd& information) {
  const MatrixXd root = information.llt().matrixL();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> axes(root.transpose() * scale_ * root);
  const MatrixXd inner = axes.operatorInverseSqrt();
  adjustment_ = root.transpose().triangularView<Eigen::Upper>().solve(inner * root.transpose());
}

double ContactPosterior::log_density(const VectorXd& coordinates) const {
  const VectorXd at =
      adjustment_.size() > 0 ? VectorXd(mode_ + adjustment_ * (coordinates - mode_)) : coordinates;
  const double rise = (least_.residuals_at(at).squaredNorm() - least_squares_) / least_.variance();
  if (!std::isfinite(rise)) return -std::numeric_limits<double>::infinity();
  if (freedom_ >= statistics::kAsGoodAsNormal) return -0.5 * rise;
  // A mode that the search missed by its tolerance may lie a little lower.
  const double above = std::max(rise / freedom_, -0.5);
  return -0.5 * (freedom_ + static_cast<double>(mode_.size())) * std::log1p(above);
}

}  // namespace strobe::impact
