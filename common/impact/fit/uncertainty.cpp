#include "common/impact/fit/uncertainty.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "common/statistics/distributions.hpp"

namespace strobe::impact {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kTolerance = 5e-3;      ///< of an end, in sds
constexpr double kRankTolerance = 1e-8;  // derivatives by differences are good to about 1e-10

struct FunctionValue {
  double at = 0.0;
  double value = 0.0;
};

/// A bracketed root by regula falsi with the Illinois rule (M. Dowell and P. Jarratt, BIT 11, 1971), for
/// functions that are costly and about straight: the end of the last bracket on the side of `second`, whose
/// value has the other sign than that of `first` or is 0. Done when the ends are within `tolerance`, or the
/// value is 0.
template <typename Function>
FunctionValue regula_falsi(Function function, FunctionValue first, FunctionValue second, double tolerance) {
  assert((first.value > 0.0) != (second.value > 0.0) || second.value == 0.0);
  constexpr int kMaxSteps = 100;
  double first_weight = first.value, second_weight = second.value;
  int last = 0;
  for (int i = 0; i < kMaxSteps && std::abs(second.at - first.at) > tolerance && second.value != 0.0; ++i) {
    const double at = first.at + (second.at - first.at) * first_weight / (first_weight - second_weight);
    const FunctionValue now{at, function(at)};
    if ((now.value > 0.0) == (first.value > 0.0) && now.value != 0.0) {
      first = now;
      first_weight = now.value;
      if (last == 1) second_weight *= 0.5;
      last = 1;
    } else {
      second = now;
      second_weight = now.value;
      if (last == 2) first_weight *= 0.5;
      last = 2;
    }
  }
  return second;
}

/// How many sds the best fit under a value of the parameter is worse than the best of all, less `t`.
class Profile {
 public:
  Profile(const Fitter& least, Parameter parameter, double unit, double t)
      : fitter_(least), parameter_(parameter), least_(least.chi2()), unit_(unit), t_(t) {}

  double operator()(double value) {
    fitter_ = fitter_.with_fixed(parameter_, value);
    fitter_.refine();
    return std::sqrt(std::max(0.0, fitter_.chi2() - least_) / unit_) - t_;
  }

 private:
  Fitter fitter_;
  Parameter parameter_;
  double least_;
  double unit_;
  double t_;
};

/// One end: steps outwards until the profile is above the step, then back to it.
std::optional<double> end_of(Profile profile, double value, double step, double bound, double t) {
  FunctionValue inside{value, -t};
  for (double reach = step; inside.at != bound; reach *= 2.0) {
    const double at = step > 0.0 ? std::min(bound, inside.at + reach) : std::max(bound, inside.at + reach);
    const FunctionValue now{at, profile(at)};
    if (now.value > 0.0) return regula_falsi(profile, inside, now, kTolerance * std::abs(step) / t).at;
    inside = now;
  }
  return std::nullopt;
}

struct Interval {
  std::optional<double>
      lower;  ///< absent where the profile stays below the step down to the parameter's bound
  std::optional<double> upper;
};

/// `sd` sets the step, the sum of squares at `sd` from the value of a linear model; `t` the interval's ends
/// in sds. `unit`: the rise of the sum of squares at one sd.
Interval profile_interval(const Fitter& least, Parameter parameter, double sd, double unit, double t) {
  const double value = least.values()[index(parameter)];
  if (!(unit > 0.0) || !(sd > 0.0)) return {value, value};
  const Profile profile(least, parameter, unit, t);
  const double radius = 0.5 * least.options().diameter_m;
  return {end_of(profile, value, -t * sd, lower_bound(parameter), t),
          end_of(profile, value, t * sd, upper_bound(parameter, radius), t)};
}

/// Least twice the logarithm of the likelihood ratio for a contact that slides, or grips: 3.5 sd, as the
/// contact that looks most like it is one of many.
constexpr double kSlidingEvidence = 12.0;
constexpr double kLimitTolerance = 1e-7;  ///< relative
constexpr double kStepDown = 0.05;        ///< first step to the limit, of the range down to the lower bound

/// Likelihoods with the weights that each fit gives the residuals, the variance known or estimated from the
/// better one.
bool may_be_noise(const Fitter& least, const Fitter& without) {
  const double chi2 = least.chi2(), rise = without.chi2() - chi2;
  const double weights = without.log_determinant() - least.log_determinant();
  if (least.options().scale == CovarianceScale::stated) return rise + weights < kSlidingEvidence;
  const int dof = least.degrees_of_freedom(), between = least.degrees_of_freedom_between();
  if (dof < 1 || between < 1 || !(without.reduced(without.chi2(), dof) > 0.0)) return true;
  const double variance = least.reduced(chi2, dof);
  return variance > 0.0 && between * std::log1p(rise / (variance * between)) + weights < kSlidingEvidence;
}

/// The largest value that some contact depends on: that of mu which the contact with the most friction needs.
/// Of e_x, its upper bound.
double largest_that_matters(const Fitter& fitter, Parameter parameter) {
  const FitOptions& options = fitter.options();
  if (parameter != Parameter::mu) return upper_bound(parameter, 0.5 * options.diameter_m);
  double largest = 0.0;
  for (const Comparison& c :
       compare(fitter.observations(), options.model, fitter.values(), options.diameter_m))
    largest = std::max(largest, std::abs(c.predicted.impulse_ratio));
  return largest;
}

/// The root of the sum of squares under a value of the parameter, from the best fit under the last one: it
/// rises about linearly beyond what the contacts allow.
class RootOfSquares {
 public:
  RootOfSquares(const Fitter& fitter, Parameter parameter) : fitter_(fitter), parameter_(parameter) {}

  double operator()(double value) {
    fitter_ = fitter_.with_fixed(parameter_, value);
    fitter_.refine();
    return std::sqrt(fitter_.chi2());
  }

 private:
  Fitter fitter_;
  Parameter parameter_;
};

/// The value below `high` below which the sum of squares has risen by `rise`, bracketed downwards; the lower
/// bound if it rises nowhere so far.
double crossing(const Fitter& fitter, Parameter parameter, double high, double rise) {
  RootOfSquares root(fitter, parameter);
  const double level = std::sqrt(fitter.chi2() + rise);
  const double least = lower_bound(parameter);
  const double tolerance = kLimitTolerance * std::abs(high);
  // What was found on the way down: from another start the same value may end in another valley, above the
  // level, too.
  FunctionValue below{high, std::sqrt(fitter.chi2()) - level}, low = below;
  for (double step = kStepDown * (high - least); low.at > least && !(low.value > 0.0); step *= 2.0) {
    below = low;
    low.at = std::max(least, low.at - step);
    low.value = root(low.at) - level;
  }
  if (!(low.value > 0.0)) return least;
  return regula_falsi([&](double value) { return root(value) - level; }, low, below, tolerance).at;
}

/// Of a fit at its least sum of squares, for mu and e_x: the lower end of a one-sided interval of kLimitLevel
/// where noise alone may have made a contact look as if it slid (mu) or gripped (e_x). Returns nullopt if the
/// parameter is not fitted, or such a contact is there: then it has a value.
///
/// Where all grip the sum of squares does not depend on mu, but has its least just below what the contact
/// with the most friction needs: its noise is then fitted by a little sliding. Likewise for e_x where all
/// slide. So the likelihood ratio of that least to the best fit with the parameter at its upper bound
/// decides, the variance being that of the residuals (of the clusters where they scatter). The limit is where
/// the sum of squares has risen over that of either by the square of Student's t, the lower of the two.
std::optional<double> limit_without_evidence(const Fitter& least, Parameter parameter) {
  if (!least.fits(parameter)) return std::nullopt;
  Fitter without = least.with_fixed(parameter, upper_bound(parameter, 0.5 * least.options().diameter_m));
  without.search_with_this_scatter();
  const double chi2 = without.chi2();
  if (!may_be_noise(least, without)) return std::nullopt;
  const int dof = without.degrees_of_freedom(), between = std::max(1, without.degrees_of_freedom_between());
  const bool stated = least.options().scale == CovarianceScale::stated;
  const double t =
      statistics::student_t_quantile(stated ? statistics::kAsGoodAsNormal : between, 1.0 - kLimitLevel);
  const double rise = t * t * (stated ? 1.0 : without.reduced(chi2, dof));
  // Each with its own weights: the value of the least sum of squares is never excluded.
  return std::min(crossing(without, parameter, largest_that_matters(without, parameter), rise),
                  crossing(least, parameter, least.values()[index(parameter)], rise));
}

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

  /// The robust variance, but not what is small by chance: where few clusters determine the parameter at
  /// least the common one, else the least that the common one would let expect.
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
      assert(ratio.degrees_of_freedom >= 1.0);
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
  for (const Parameter p : {Parameter::mu, Parameter::e_x}) {
    FittedParameter& parameter = fit.parameters[index(p)];
    parameter.limit = parameter.lower = limit_without_evidence(fitter, p);
    if (parameter.limit) parameter.status = ParameterStatus::undetermined;
  }
  return Uncertainty(fitter, fit).add();
}

}  // namespace strobe::impact
