// The inverse of the in/out models: which friction, tangential restitution, offset of the normal force and
// inertia the measured rebounds tell of. Weighted least squares of the lift-off's vx and R·omega within the
// parameters' bounds (bounded_least_squares.hpp), from several starts since regime changes make kinks. Each
// observation's own e is used. Deterministic; thread-safe; allocates; milliseconds for 21 observations.
#pragma once

#include <Eigen/Dense>
#include <optional>
#include <span>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "common/impact/fit/rebound_model.hpp"

namespace strobe::impact {

enum class Weighting {
  /// 1 m/s of vx counts like 1 m/s of R·omega, in every observation alike (times the two weights of
  /// FitOptions).
  equal,
  /// By the observation's standard deviations: those of lift-off, and those of touchdown and e carried
  /// through the model (input_covariance(), which correlates vx and R·omega), taken anew where the fit ends.
  stated_sd,
};

enum class CovarianceScale {
  residuals,  ///< times chi2/dof: weights are relative, the level comes from the residuals (dof >= 1)
  stated,     ///< the weights' own: honest where the stated sd are all there is, that is chi2/dof near 1
};

using FreeParameters = std::array<bool, kParameterCount>;

struct FitOptions {
  ReboundModel model = ReboundModel::grip_offset;
  double diameter_m = ball::kThesisDiameter_m;
  ParameterValues start = default_values(ReboundModel::grip_offset);  ///< value of what is not free
  FreeParameters free{true, true, true, true, false};  ///< none: the model as it stands is judged
  Weighting weighting = Weighting::equal;
  CovarianceScale scale = CovarianceScale::residuals;
  double vx_weight = 1.0;    ///< of a squared residual of vx; > 0. Only with Weighting::equal.
  double spin_weight = 1.0;  ///< of a squared residual of R·omega
};

/// The model with its default values and what is fitted of it by default: mu of slide_roll; mu, e_x of grip;
/// mu, e_x, d, u0 of grip_offset.
FitOptions default_options(ReboundModel model);

enum class ParameterStatus {
  fixed,   ///< not asked for
  fitted,  ///< within its bounds: value ± sd
  /// The fit presses against the bound. `limit` is the other end of a one-sided interval of at least
  /// kLimitLevel, the fitted parameters following along, linearized; absent where nothing changes with the
  /// parameter.
  at_lower_bound,
  at_upper_bound,
  /// Nothing changes with it at the fit. Of mu, where all observations grip, `limit` is the least that lets
  /// them.
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
  std::optional<double> limit;  ///< one end of an interval open to the other side: see ParameterStatus
};

/// One observation against the prediction. Residual: measured less predicted.
struct Comparison {
  Rebound predicted;
  double vx_residual_mps = 0.0;
  double omega_residual_radps = 0.0;
  std::optional<double> z_vx;  ///< residual over the lift-off's stated sd; absent if that is 0
  std::optional<double> z_omega;
  /// Over the sd of lift-off and of the prediction from touchdown and e (not from the parameters).
  std::optional<double> z_vx_with_inputs;
  std::optional<double> z_omega_with_inputs;
};

/// Over several comparisons; the z-scores that are absent are left out.
struct Agreement {
  double rms_vx_mps = 0.0;
  double rms_omega_radps = 0.0;
  int count = 0;
  int within_sd_vx = 0;  ///< |z| <= 1
  int within_sd_omega = 0;
  double rms_z_vx = 0.0;
  double rms_z_omega = 0.0;
};

Agreement agreement_of(std::span<const Comparison> comparisons);

struct ModelFit {
  std::array<FittedParameter, kParameterCount> parameters;
  /// Of all parameters, rows and columns of those that are not `fitted` zero; units of the parameters.
  Eigen::Matrix<double, kParameterCount, kParameterCount> covariance;
  double chi2 = 0.0;            ///< weighted sum of squares; (m/s)² with Weighting::equal
  int dof = 0;                  ///< numbers less the parameters asked for
  double variance_scale = 1.0;  ///< by which the covariance was multiplied
  bool converged = false;
  std::vector<Comparison> comparisons;  ///< one for each observation, in order
  Agreement agreement;

  ParameterValues values() const;
  /// Correlation of two fitted parameters; 0 where one of them is not.
  double correlation(Parameter a, Parameter b) const;
};

enum class FitError {
  no_observations,
  invalid_observation,     ///< `input` says what is wrong with `observation`
  sd_not_usable,           ///< an sd is negative or not finite, or one of lift-off is 0 with stated_sd
  invalid_options,         ///< diameter or weights not positive and finite
  parameter_not_in_model,  ///< free, but the model does not have it
  value_out_of_bounds,     ///< a start or fixed value
  too_few_numbers,         ///< more parameters than numbers, or none to spare for CovarianceScale::residuals
  not_identifiable,        ///< parameters depend on each other: others fit as well
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

/// The observations against a model with given parameters. Preconditions: those that fit() checks.
std::vector<Comparison> compare(std::span<const Observation> observations, ReboundModel model,
                                const ParameterValues& parameters, double diameter_m);

}  // namespace strobe::impact
