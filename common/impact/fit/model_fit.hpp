// Fits the rebound models: which friction, tangential restitution, offset of the normal force and inertia
// explain the measured rebounds best. Weighted least squares of the lift-off's vx and R·omega within the
// parameters' bounds (bounded_least_squares.hpp), from several starts since changes of regime make kinks.
// Each observation's own e is used. Deterministic; thread-safe; allocates; milliseconds for 21 observations.
#pragma once

#include <Eigen/Dense>
#include <optional>
#include <span>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "common/impact/fit/comparison.hpp"

namespace strobe::impact {

enum class Weighting {
  /// 1 m/s of vx has the weight of 1 m/s of R·omega, in every observation (times the two weights of
  /// FitOptions).
  equal,
  /// By the observation's standard deviations: those of lift-off, and those of touchdown and e propagated
  /// through the model (input_covariance(), which correlates vx and R·omega), updated until the fit is
  /// consistent with them.
  stated_sd,
};

enum class CovarianceScale {
  residuals,  ///< times chi2/dof: the weights are relative, the variance comes from the residuals (dof >= 1)
  stated,     ///< that of the weights: valid if no other errors exist (chi2/dof near 1)
};

using FreeParameters = std::array<bool, kParameterCount>;

struct FitOptions {
  ReboundModel model = ReboundModel::grip_offset;
  double diameter_m = ball::kThesisDiameter_m;
  ParameterValues start = default_values(ReboundModel::grip_offset);  ///< or fixed value
  FreeParameters free{true, true, true, true, false};  ///< none free: the model is evaluated at `start`
  Weighting weighting = Weighting::equal;
  CovarianceScale scale = CovarianceScale::residuals;
  double vx_weight = 1.0;    ///< of a squared residual of vx; > 0. Only with Weighting::equal.
  double spin_weight = 1.0;  ///< of a squared residual of R·omega
};

/// The model with its default values and what is fitted of it by default: mu of slide_roll; mu, e_x of grip;
/// mu, e_x, d, u0 of grip_offset.
FitOptions default_options(ReboundModel model);

enum class ParameterStatus {
  fixed,   ///< not free
  fitted,  ///< within its bounds: value ± sd
  /// The minimum is at the bound. `limit` is the other end of a one-sided interval of at least kLimitLevel
  /// with the fitted parameters optimized along (profile likelihood, linearized); absent where nothing
  /// changes with the parameter.
  at_lower_bound,
  at_upper_bound,
  /// Nothing changes with it at the minimum; or mu, where noise alone may explain that a contact seems to slide: all
  /// may grip (likelihood ratio below that of 3.5 sd). Of mu, `limit` is the lower end of a one-sided interval of
  /// kLimitLevel, and the value the one with the least chi2.
  undetermined,
};

constexpr std::string_view name(ParameterStatus status) {
  constexpr std::array<std::string_view, 5> names{"fixed", "fitted", "at lower bound", "at upper bound",
                                                  "undetermined"};
  return names[static_cast<std::size_t>(status)];
}

inline constexpr double kLimitLevel = 0.95;  ///< of the one-sided intervals

struct FittedParameter {
  double value = 0.0;
  ParameterStatus status = ParameterStatus::fixed;
  std::optional<double> sd;     ///< fitted only
  std::optional<double> limit;  ///< see ParameterStatus
};

struct ModelFit {
  std::array<FittedParameter, kParameterCount> parameters;
  /// Of all parameters, in their units; rows and columns of those that are not `fitted` are 0.
  Eigen::Matrix<double, kParameterCount, kParameterCount> covariance;
  double chi2 = 0.0;            ///< weighted sum of squares; (m/s)² with Weighting::equal
  int dof = 0;                  ///< two per observation, less the free parameters
  double variance_scale = 1.0;  ///< factor of the covariance
  bool converged = false;
  std::vector<Comparison> comparisons;  ///< one for each observation, in order
  ResidualStatistics statistics;

  ParameterValues values() const;
  /// Correlation of two fitted parameters; 0 where one of them is not.
  double correlation(Parameter a, Parameter b) const;
};

enum class FitError {
  no_observations,
  invalid_observation,     ///< `input` says what is wrong with `observation`
  invalid_sd,              ///< an sd is negative or not finite, or one of lift-off is 0 with stated_sd
  invalid_options,         ///< diameter or weights not positive and finite
  parameter_not_in_model,  ///< free, but the model does not have it
  value_out_of_bounds,     ///< a start or fixed value
  underdetermined,         ///< more parameters than numbers, or no dof left for CovarianceScale::residuals
  not_identifiable,        ///< parameters depend on each other
};

struct FitFailure {
  FitError error = FitError::no_observations;
  std::size_t observation = 0;
  InputError input = InputError::not_finite;
  Parameter parameter = Parameter::mu;
};

/// One line that names the observation or parameter concerned.
std::string message(const FitFailure& failure, std::span<const Observation> observations);

tl::expected<ModelFit, FitFailure> fit(std::span<const Observation> observations, const FitOptions& options);

}  // namespace strobe::impact
