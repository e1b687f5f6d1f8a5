#include "common/impact/fit/model_fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/impact/fit/bounded_least_squares.hpp"
#include "common/impact/fit/fit_checks.hpp"

namespace strobe::impact {

namespace {

using Eigen::Index;
using Eigen::Matrix2d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr std::size_t kStartsTried = 6;
constexpr int kMaxReweightings = 12;
constexpr double kRankTolerance = 1e-8;            // derivatives by differences are good to about 1e-10
constexpr double kOneSidedZ = 1.6448536269514722;  // normal quantile of kLimitLevel
/// Least twice the logarithm of the likelihood ratio for a contact that slides: 3.5 sd, as the contact that looks most
/// like it is one of many.
constexpr double kSlidingEvidence = 12.0;
constexpr int kBisections = 30;
constexpr double kJustEnough =
    1.0001;  // of the friction that all need: more than the finite differences move it

/// A fit in progress: the free parameters and the weights of the residuals.
class Fitter {
 public:
  Fitter(std::span<const Observation> observations, const FitOptions& options)
      : observations_(observations), options_(options), values_(options.start) {
    for (std::size_t i = 0; i < kParameterCount; ++i)
      if (options.free[i]) free_.push_back(static_cast<Parameter>(i));
    weights_.resize(observations.size(), equal_weight());
    if (options.weighting == Weighting::stated_sd) reweight(false);
  }

  ModelFit run() {
    fit_once(kStartsTried);
    if (options_.weighting == Weighting::stated_sd) iterate_weights();
    settle_friction();
    ModelFit out;
    out.converged = converged_;
    out.comparisons = compare(observations_, options_.model, values_, options_.diameter_m);
    out.statistics = residual_statistics(out.comparisons);
    out.chi2 = chi2();
    out.dof = degrees_of_freedom();
    if (options_.scale == CovarianceScale::residuals) out.variance_scale = reduced_chi2(out.chi2, out.dof);
    return out;
  }

  const std::vector<Parameter>& free() const { return free_; }
  /// Of mu, where the observations may all grip: what settle_friction() found.
  const std::optional<double>& least_friction() const { return least_friction_; }
  const ParameterValues& values() const { return values_; }

  VectorXd free_values() const {
    VectorXd out(static_cast<Index>(free_.size()));
    for (std::size_t k = 0; k < free_.size(); ++k) out[static_cast<Index>(k)] = values_[index(free_[k])];
    return out;
  }

  /// Weighted residuals, predicted less measured: two for each observation.
  VectorXd residuals_at(const VectorXd& at) const {
    const ParameterValues values = with(at);
    VectorXd out(static_cast<Index>(2 * observations_.size()));
    for (std::size_t i = 0; i < observations_.size(); ++i) {
      const Observation& o = observations_[i];
      const auto predicted = rebound_of(options_.model, values, options_.diameter_m, o.touchdown, o.e);
      const Vector2d residual(
          predicted->lift_off.vx_mps - o.lift_off.vx_mps,
          0.5 * options_.diameter_m * (predicted->lift_off.omega_radps - o.lift_off.omega_radps));
      out.segment<2>(static_cast<Index>(2 * i)) = weights_[i] * residual;
    }
    return out;
  }

  LeastSquaresProblem problem() const {
    const auto n = static_cast<Index>(free_.size());
    const double radius = 0.5 * options_.diameter_m;
    const ParameterValues scales{0.1, 0.1, 0.1 * radius, 1.0, 0.1};
    LeastSquaresProblem out{.residuals = [this](const VectorXd& at) { return residuals_at(at); },
                            .lower = VectorXd(n),
                            .upper = VectorXd(n),
                            .scale = VectorXd(n)};
    for (Index k = 0; k < n; ++k) {
      const Parameter p = free_[static_cast<std::size_t>(k)];
      out.lower[k] = lower_bound(p);
      out.upper[k] = upper_bound(p, radius);
      out.scale[k] = scales[index(p)];
    }
    return out;
  }

 private:
  ParameterValues with(const VectorXd& at) const {
    ParameterValues out = values_;
    for (std::size_t k = 0; k < free_.size(); ++k) out[index(free_[k])] = at[static_cast<Index>(k)];
    return out;
  }

  Matrix2d equal_weight() const {
    return Vector2d(std::sqrt(options_.vx_weight), std::sqrt(options_.spin_weight)).asDiagonal();
  }

  /// Whitening: the inverse of the Cholesky factor of the residual's covariance.
  void reweight(bool with_inputs) {
    for (std::size_t i = 0; i < observations_.size(); ++i) {
      const Observation& o = observations_[i];
      InputCovariance c;
      if (with_inputs) c = input_covariance(options_.model, values_, options_.diameter_m, o);
      c.vx += std::pow(o.lift_off_sd.vx_mps, 2);
      c.spin += std::pow(0.5 * options_.diameter_m * o.lift_off_sd.omega_radps, 2);
      const double first = std::sqrt(c.vx);
      const double across = c.cross / first;
      const double second = std::sqrt(std::max(c.spin - across * across, std::numeric_limits<double>::min()));
      weights_[i] << 1.0 / first, 0.0, -across / (first * second), 1.0 / second;
    }
  }

  void fit_once(std::size_t tries) {
    if (free_.empty()) {
      converged_ = true;
      return;
    }
    const LeastSquaresResult found = minimize(problem(), free_values(), candidates(tries), tries);
    values_ = with(found.parameters);
    converged_ = found.converged;
  }

  /// The weights depend on the parameters through the inputs' errors: alternate until the parameters
  /// converge.
  void iterate_weights() {
    const VectorXd scale = problem().scale;
    for (int i = 0; i < kMaxReweightings; ++i) {
      const VectorXd before = free_values();
      reweight(true);
      fit_once(i == 0 ? kStartsTried : 0);
      if (((free_values() - before).array().abs() <= 1e-7 * scale.array()).all()) return;
    }
  }

  /// A grid over the free parameters.
  std::vector<VectorXd> candidates(std::size_t tries) const {
    if (tries == 0) return {};
    const double radius = 0.5 * options_.diameter_m;
    const std::array<std::vector<double>, kParameterCount> grid{{{0.15, 0.35, 0.55, 0.8},
                                                                 {0.0, 0.15, 0.5},
                                                                 {0.01 * radius, 0.08 * radius, 0.2 * radius},
                                                                 {0.3, 2.5, 10.0},
                                                                 {0.4, 0.5, 0.6}}};
    std::vector<VectorXd> out{free_values()};
    for (std::size_t k = 0; k < free_.size(); ++k) {
      std::vector<VectorXd> longer;
      for (const VectorXd& c : out) {
        for (const double value : grid[index(free_[k])]) {
          longer.push_back(c);
          longer.back()[static_cast<Index>(k)] = value;
        }
      }
      out = std::move(longer);
    }
    return out;
  }

  /// chi2/dof; 0 where the residuals are within rounding.
  double reduced_chi2(double chi2, int dof) const {
    double rounding = 0.0;
    for (std::size_t i = 0; i < observations_.size(); ++i) {
      const Observation& o = observations_[i];
      const double largest = std::abs(o.touchdown.vx_mps) + std::abs(o.touchdown.vy_mps) +
                             options_.diameter_m * std::abs(o.touchdown.omega_radps);
      const Vector2d error = Vector2d::Constant(16.0 * std::numeric_limits<double>::epsilon() * largest);
      rounding += (weights_[i].cwiseAbs() * error).squaredNorm();
    }
    return chi2 <= rounding ? 0.0 : chi2 / dof;
  }

  double chi2() const { return residuals_at(free_values()).squaredNorm(); }

  /// The same fit with another friction, which is not fitted; under the same weights.
  Fitter with_friction(double mu) const {
    Fitter out(*this);
    out.values_[index(Parameter::mu)] = mu;
    std::erase(out.free_, Parameter::mu);
    out.fit_once(kStartsTried);
    return out;
  }

  /// Whether noise alone may have made one contact look as if it slid. Where all grip the sum of squares does not
  /// depend on mu, but has its least just below what the contact with the most friction needs: its noise is then
  /// fitted by a little sliding. A likelihood ratio, of unknown variance where that is estimated.
  bool may_all_grip(double least, double gripping) const {
    const int dof = degrees_of_freedom();
    if (options_.scale == CovarianceScale::stated) return gripping - least < kSlidingEvidence;
    if (dof < 1 || !(reduced_chi2(gripping, dof) > 0.0)) return true;
    return reduced_chi2(least, dof) > 0.0 && dof * std::log(gripping / least) < kSlidingEvidence;
  }

  /// Where all may grip mu is not determined, and a lower limit is found: where the sum of squares has risen by
  /// kOneSidedZ². The values stay those of the least sum of squares.
  void settle_friction() {
    if (std::find(free_.begin(), free_.end(), Parameter::mu) == free_.end()) return;
    const Fitter gripping = with_friction(upper_bound(Parameter::mu, 0.5 * options_.diameter_m));
    if (!may_all_grip(chi2(), gripping.chi2())) return;
    const double variance = options_.scale == CovarianceScale::stated
                                ? 1.0
                                : reduced_chi2(gripping.chi2(), degrees_of_freedom() + 1);
    least_friction_ = gripping.lower_limit(gripping.chi2() + kOneSidedZ * kOneSidedZ * variance);
  }

  double largest_impulse_ratio() const {
    double largest = 0.0;
    for (const Comparison& c : compare(observations_, options_.model, values_, options_.diameter_m))
      largest = std::max(largest, std::abs(c.predicted.impulse_ratio));
    return largest;
  }

  /// The least friction whose sum of squares is at most `limit`.
  double lower_limit(double limit) const {
    double low = 0.0, high = largest_impulse_ratio();
    for (int i = 0; i < kBisections; ++i) {
      const double middle = 0.5 * (low + high);
      (with_friction(middle).chi2() <= limit ? high : low) = middle;
    }
    return high;
  }

  int degrees_of_freedom() const {
    return static_cast<int>(2 * observations_.size()) - static_cast<int>(free_.size());
  }

  std::span<const Observation> observations_;
  const FitOptions& options_;
  ParameterValues values_;
  std::vector<Parameter> free_;
  std::vector<Matrix2d> weights_;
  bool converged_ = false;
  std::optional<double> least_friction_;
};

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
    const bool any_friction =
        fitter.free()[static_cast<std::size_t>(k)] == Parameter::mu && fitter.least_friction();
    parameter.status = any_friction ? ParameterStatus::undetermined : ParameterStatus::fitted;
    if (any_friction) continue;
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

/// The distance from its bound at which the linearized sum of squares has risen by z².
void set_limit(const MatrixXd& fitted, const VectorXd& column, const VectorXd& residuals, double scale,
               const LeastSquaresProblem& problem, Index k, FittedParameter& parameter) {
  VectorXd alone = column;
  if (fitted.cols() > 0) alone -= fitted * fitted.colPivHouseholderQr().solve(column);
  if (alone.norm() <= kRankTolerance * column.norm() || column.norm() == 0.0) return;
  const double rise = kOneSidedZ * kOneSidedZ * scale;
  const double slope = std::abs(alone.dot(residuals));
  const double root = slope + std::sqrt(slope * slope + alone.squaredNorm() * rise);
  const double away = root > 0.0 ? rise / root : 0.0;
  const bool low = parameter.status == ParameterStatus::at_lower_bound;
  parameter.limit = std::clamp(parameter.value + (low ? away : -away), problem.lower[k], problem.upper[k]);
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

tl::expected<void, FitFailure> add_uncertainty(const Fitter& fitter, ModelFit& fit) {
  if (fitter.free().empty()) return {};
  const LeastSquaresProblem problem = fitter.problem();
  const VectorXd at = fitter.free_values();
  const MatrixXd jac = jacobian(problem, at);
  const Columns columns = sort_columns(fitter, problem, jac, fit);
  const MatrixXd fitted = picked(jac, columns.fitted);
  const auto covariance = unscaled_covariance(fitted, kRankTolerance);
  if (!covariance)
    return tl::unexpected(FitFailure{.error = FitError::not_identifiable,
                                     .parameter = redundant_parameter(jac, columns.fitted, fitter)});
  const auto place = [&](std::size_t k) {
    return index(fitter.free()[static_cast<std::size_t>(columns.fitted[k])]);
  };
  for (std::size_t a = 0; a < columns.fitted.size(); ++a) {
    for (std::size_t b = 0; b < columns.fitted.size(); ++b)
      fit.covariance(static_cast<Index>(place(a)), static_cast<Index>(place(b))) =
          fit.variance_scale * (*covariance)(static_cast<Index>(a), static_cast<Index>(b));
    const auto diagonal = static_cast<Index>(place(a));
    fit.parameters[place(a)].sd = std::sqrt(fit.covariance(diagonal, diagonal));
  }
  const VectorXd residuals = fitter.residuals_at(at);
  for (const Index k : columns.at_bound)
    set_limit(fitted, jac.col(k), residuals, fit.variance_scale, problem, k,
              fit.parameters[index(fitter.free()[static_cast<std::size_t>(k)])]);
  FittedParameter& mu = fit.parameters[index(Parameter::mu)];
  if (mu.status == ParameterStatus::undetermined) mu.limit = fitter.least_friction();
  return {};
}

}  // namespace

tl::expected<ModelFit, FitFailure> fit(std::span<const Observation> observations, const FitOptions& options) {
  if (const auto failure = find_failure(observations, options)) return tl::unexpected(*failure);
  Fitter fitter(observations, options);
  ModelFit out = fitter.run();
  out.covariance.setZero();
  for (std::size_t i = 0; i < kParameterCount; ++i) out.parameters[i].value = fitter.values()[i];
  if (const auto added = add_uncertainty(fitter, out); !added) return tl::unexpected(added.error());
  return out;
}

FitOptions default_options(ReboundModel model) {
  FitOptions out{.model = model, .start = default_values(model), .free = {}};
  out.free[index(Parameter::mu)] = true;
  out.free[index(Parameter::e_x)] = model != ReboundModel::slide_roll;
  out.free[index(Parameter::offset_m)] = model == ReboundModel::grip_offset;
  out.free[index(Parameter::offset_reference_mps)] = model == ReboundModel::grip_offset;
  return out;
}

ParameterValues ModelFit::values() const {
  ParameterValues out{};
  for (std::size_t i = 0; i < kParameterCount; ++i) out[i] = parameters[i].value;
  return out;
}

double ModelFit::correlation(Parameter a, Parameter b) const {
  const auto i = static_cast<Index>(index(a));
  const auto j = static_cast<Index>(index(b));
  const double scale = std::sqrt(covariance(i, i)) * std::sqrt(covariance(j, j));
  return scale > 0.0 ? covariance(i, j) / scale : 0.0;
}

}  // namespace strobe::impact
