#include "common/impact/fit/clustered_covariance.hpp"

#include <algorithm>

#include "common/statistics/distributions.hpp"

namespace strobe::impact {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Eigenvalues of I - H below this: the cluster alone determines a parameter, and its residual there is rounding.
constexpr double kNoResidual = 1e-6;

/// The symmetric matrix that gives the residuals of a cluster the variance of its errors: (I - H)^(-1/2).
MatrixXd bias_reduction(const MatrixXd& leverage) {
  const Index n = leverage.rows();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> axes(MatrixXd::Identity(n, n) - leverage);
  const VectorXd factors = axes.eigenvalues().unaryExpr(
      [](double value) { return value > kNoResidual ? 1.0 / std::sqrt(value) : 0.0; });
  return axes.eigenvectors() * factors.asDiagonal() * axes.eigenvectors().transpose();
}

/// Satterthwaite's: of the quadratic form whose eigenvalues are those of the Gram matrix of `terms`, twice the square of
/// its mean over its variance.
double satterthwaite(const MatrixXd& terms) {
  const MatrixXd gram = terms.transpose() * terms;
  const double spread = gram.squaredNorm();
  return spread > 0.0 ? std::max(1.0, gram.trace() * gram.trace() / spread) : 1.0;
}

}  // namespace

ClusteredCovariance clustered_covariance(const MatrixXd& jacobian, const VectorXd& residuals,
                                         const std::vector<std::vector<Index>>& clusters) {
  const Index rows = jacobian.rows(), parameters = jacobian.cols();
  const auto count = static_cast<Index>(clusters.size());
  // Parameters from residuals.
  const MatrixXd inverse = jacobian.colPivHouseholderQr().solve(MatrixXd::Identity(rows, rows));
  const MatrixXd leverage = jacobian * inverse;
  MatrixXd score(parameters, count);
  std::vector<MatrixXd> terms(static_cast<std::size_t>(parameters), MatrixXd(rows, count));
  for (Index g = 0; g < count; ++g) {
    const auto& members = clusters[static_cast<std::size_t>(g)];
    const MatrixXd weights = inverse(Eigen::all, members) * bias_reduction(leverage(members, members));
    score.col(g) = weights * residuals(members);
    for (Index k = 0; k < parameters; ++k) {
      const VectorXd w = weights.row(k).transpose();
      VectorXd term = -leverage(Eigen::all, members) * w;
      term(members) += w;
      terms[static_cast<std::size_t>(k)].col(g) = term;
    }
  }
  ClusteredCovariance out{score * score.transpose(), VectorXd(parameters)};
  for (Index k = 0; k < parameters; ++k)
    out.degrees_of_freedom[k] = satterthwaite(terms[static_cast<std::size_t>(k)]);
  return out;
}

double least_robust_share(double degrees_of_freedom) {
  constexpr double kByChance = 0.02;
  if (degrees_of_freedom < kFewDegrees) return 1.0;
  return statistics::chi_squared_quantile(degrees_of_freedom, kByChance) / degrees_of_freedom;
}

std::vector<std::vector<Eigen::Index>> rows_of_pairs(const std::vector<std::vector<std::size_t>>& clusters) {
  std::vector<std::vector<Eigen::Index>> out;
  for (const auto& cluster : clusters) {
    out.emplace_back();
    for (const std::size_t i : cluster)
      for (const Eigen::Index component : {0, 1})
        out.back().push_back(static_cast<Eigen::Index>(2 * i) + component);
  }
  return out;
}

}  // namespace strobe::impact
