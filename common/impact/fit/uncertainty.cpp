#include "common/impact/fit/uncertainty.hpp"

#include <algorithm>
#include <cmath>

#include "common/impact/fit/clustered_covariance.hpp"
#include "common/impact/fit/confidence_interval.hpp"
#include "common/statistics/distributions.hpp"

namespace strobe::impact {

namespace {

using Eigen::Index;
using Eigen::Matrix2d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr double kRankTolerance = 1e-8;  // derivatives by differences are good to about 1e-10

/// Columns of the Jacobian by the status of their parameters.
struct Columns {
  std::vector<Index> fitted;
  std::vector<Index> at_bound;
};

MatrixXd picked(const MatrixXd& jac, const std::vector<Index>& columns) {
  MatrixXd out(jac.rows(), static_cast<Index>(columns.size()));
  for (std::size_t k = 0; k < columns.size(); ++k) out.col(static_cast<Index>(k)) = jac.col(columns[k]);
  return out;
}

Columns sort_columns(const Fitter& fitter, const LeastSquaresProblem& problem, const MatrixXd& jac,
                     ModelFit& fit) {
  Columns out;
  const VectorXd at = fitter.free_values();
  const double strongest = (jac * problem.scale.asDiagonal()).colwise().norm().maxCoeff();
  for (Index k = 0; k < at.size(); ++k) {
    FittedParameter& parameter = fit.parameters[index(fitter.free()[static_cast<std::size_t>(k)])];
    const double near = 1e-9 * problem.scale[k];
    if (parameter.status == ParameterStatus::undetermined) continue;
    parameter.status = ParameterStatus::fitted;
    if (at[k] <= problem.lower[k] + near) parameter.status = ParameterStatus::at_lower_bound;
    if (at[k] >= problem.upper[k] - near) parameter.status = ParameterStatus::at_upper_bound;
    if (parameter.status != ParameterStatus::fitted) {
      out.at_bound.push_back(k);
    } else if (problem.scale[k] * jac.col(k).norm() <= kRankTolerance * strongest) {
      parameter.status = ParameterStatus::undetermined;
    } else {
      out.fitted.push_back(k);
    }
  }
  return out;
}

/// The distance from its bound at which the linearized sum of squares has risen by `rise`.
void set_limit(const MatrixXd& fitted, const VectorXd& column, const VectorXd& residuals, double rise,
               const LeastSquaresProblem& problem, Index k, FittedParameter& parameter) {
  VectorXd alone = column;
  if (fitted.cols() > 0) alone -= fitted * fitted.colPivHouseholderQr().solve(column);
  if (alone.norm() <= kRankTolerance * column.norm() || column.norm() == 0.0) return;
  const double slope = std::abs(alone.dot(residuals));
  const double root = slope + std::sqrt(slope * slope + alone.squaredNorm() * rise);
  const double away = root > 0.0 ? rise / root : 0.0;
  const bool low = parameter.status == ParameterStatus::at_lower_bound;
  parameter.limit = std::clamp(parameter.value + (low ? away : -away), problem.lower[k], problem.upper[k]);
  (low ? parameter.upper : parameter.lower) = parameter.limit;
}

/// A parameter without which the others are identifiable.
Parameter redundant_parameter(const MatrixXd& jac, const std::vector<Index>& fitted, const Fitter& fitter) {
  for (std::size_t k = fitted.size(); k-- > 0;) {
    std::vector<Index> others = fitted;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(k));
    if (unscaled_covariance(picked(jac, others), kRankTolerance))
      return fitter.free()[static_cast<std::size_t>(fitted[k])];
  }
  return fitter.free()[static_cast<std::size_t>(fitted.front())];
}

/// The variance of a parameter over that of the weights alone, and the degrees of freedom of Student's t.
struct VarianceRatio {
  double variance = 1.0;
  double degrees_of_freedom = statistics::kAsGoodAsNormal;
};

/// What is known of the uncertainty at the least sum of squares.
class Uncertainty {
 public:
  Uncertainty(const Fitter& fitter, ModelFit& fit)
      : fitter_(fitter),
        fit_(fit),
        problem_(fitter.problem()),
        jacobian_(jacobian(problem_, fitter.free_values())),
        residuals_(fitter.residuals_at(fitter.free_values())),
        columns_(sort_columns(fitter, problem_, jacobian_, fit)) {}

  tl::expected<void, FitFailure> add() {
    const MatrixXd fitted = picked(jacobian_, columns_.fitted);
    const auto unscaled = unscaled_covariance(fitted, kRankTolerance);
    if (!unscaled)
      return tl::unexpected(
          FitFailure{.error = FitError::not_identifiable,
                     .parameter = redundant_parameter(jacobian_, columns_.fitted, fitter_)});
    add_covariance(fitted, *unscaled);
    for (const Index k : columns_.at_bound) add_limit(fitted, k);
    return {};
  }

 private:
  Parameter parameter(Index column) const { return fitter_.free()[static_cast<std::size_t>(column)]; }

  /// One for all parameters unless they are of the clusters.
  VarianceRatio common_ratio() const {
    if (fitter_.options().scale == CovarianceScale::stated) return {};
    return {fit_.variance_scale, static_cast<double>(std::max(1, fitter_.degrees_of_freedom_between()))};
  }

  /// The robust variance, but not what is small by chance: where few clusters determine the parameter at least the common
  /// one, else the least that the common one would let expect.
  std::vector<VarianceRatio> ratios_of(const MatrixXd& columns, const MatrixXd& unscaled,
                                       MatrixXd& correlated) const {
    std::vector<VarianceRatio> out(static_cast<std::size_t>(columns.cols()), common_ratio());
    correlated = unscaled;
    if (fitter_.options().scale != CovarianceScale::clustered || fit_.variance_scale == 0.0 || out.empty())
      return out;
    const ClusteredCovariance robust =
        clustered_covariance(columns, residuals_, rows_of_pairs(fitter_.clusters()));
    if (robust.covariance.diagonal().minCoeff() > 0.0) correlated = robust.covariance;
    for (Index k = 0; k < columns.cols(); ++k) {
      VarianceRatio& ratio = out[static_cast<std::size_t>(k)];
      const double variance = robust.covariance(k, k) / unscaled(k, k);
      const double degrees = robust.degrees_of_freedom[k];
      ratio.variance = std::max(variance, least_robust_share(degrees) * ratio.variance);
      if (degrees >= kFewDegrees || fitter_.scatters()) ratio.degrees_of_freedom = degrees;
    }
    return out;
  }

  void add_covariance(const MatrixXd& fitted, const MatrixXd& unscaled) {
    MatrixXd correlated;
    const std::vector<VarianceRatio> ratios = ratios_of(fitted, unscaled, correlated);
    VectorXd sd(fitted.cols());
    for (Index k = 0; k < fitted.cols(); ++k) {
      const VarianceRatio& ratio = ratios[static_cast<std::size_t>(k)];
      const double once = std::sqrt(ratio.variance * unscaled(k, k));
      const bool clustered = fitter_.options().scale == CovarianceScale::clustered;
      sd[k] = once * (clustered
                          ? statistics::student_t_quantile(ratio.degrees_of_freedom, statistics::kAboveOneSd)
                          : 1.0);
      FittedParameter& out = fit_.parameters[index(parameter(columns_.fitted[static_cast<std::size_t>(k)]))];
      out.sd = sd[k];
      out.degrees_of_freedom = ratio.degrees_of_freedom;
      const double t = statistics::student_t_quantile(ratio.degrees_of_freedom, 0.5 * (1.0 - kIntervalLevel));
      const Interval interval = profile_interval(
          fitter_, parameter(columns_.fitted[static_cast<std::size_t>(k)]), once, ratio.variance, t);
      out.lower = interval.lower;
      out.upper = interval.upper;
    }
    const VectorXd scale = sd.cwiseQuotient(correlated.diagonal().cwiseSqrt());
    for (Index a = 0; a < fitted.cols(); ++a)
      for (Index b = 0; b < fitted.cols(); ++b)
        fit_.covariance(place(a), place(b)) = a == b ? sd[a] * sd[a] : scale[a] * scale[b] * correlated(a, b);
  }

  Index place(Index fitted) const {
    return static_cast<Index>(index(parameter(columns_.fitted[static_cast<std::size_t>(fitted)])));
  }

  void add_limit(const MatrixXd& fitted, Index k) {
    MatrixXd both(fitted.rows(), fitted.cols() + 1), correlated;
    both << fitted, jacobian_.col(k);
    VarianceRatio ratio = common_ratio();
    if (const auto unscaled = unscaled_covariance(both, kRankTolerance))
      ratio = ratios_of(both, *unscaled, correlated).back();
    const double t = statistics::student_t_quantile(ratio.degrees_of_freedom, 1.0 - kLimitLevel);
    FittedParameter& out = fit_.parameters[index(parameter(k))];
    out.degrees_of_freedom = ratio.degrees_of_freedom;
    set_limit(fitted, jacobian_.col(k), residuals_, t * t * ratio.variance, problem_, k, out);
  }

  const Fitter& fitter_;
  ModelFit& fit_;
  LeastSquaresProblem problem_;
  MatrixXd jacobian_;
  VectorXd residuals_;
  Columns columns_;
};

}  // namespace

tl::expected<void, FitFailure> add_uncertainty(const Fitter& fitter, ModelFit& fit) {
  if (fitter.free().empty()) return {};
  return Uncertainty(fitter, fit).add();
}

}  // namespace strobe::impact
