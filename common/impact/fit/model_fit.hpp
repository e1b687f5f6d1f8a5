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

#include "common/impact/fit/bounded_least_squares.hpp"
#include "common/impact/fit/rebound_model.hpp"
#include "common/sampling/sample.hpp"

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
  /// From the residuals, whatever their variances and however alike the shots of a series are:
  /// bounded_least_squares.hpp,
  /// each series a cluster. What misfits of the model and scatter of the conditions add is in it.
  clustered,
  residuals,  ///< times chi2/dof: the residuals are independent, their variances as the weights have them
              ///< (dof >= 1)
  stated,     ///< that of the weights: valid if no other errors exist (chi2/dof near 1)
};

constexpr std::string_view name(CovarianceScale scale) {
  constexpr std::array<std::string_view, 3> names{"clustered", "residuals", "stated"};
  return names[static_cast<std::size_t>(scale)];
}

/// How the posterior of ode's coefficients is found (contact_posterior.hpp).
enum class PosteriorMethod {
  automatic,   ///< importance, and where that is not reliable metropolis
  laplace,     ///< the normal or t distribution at the mode, unchecked
  importance,  ///< draws from that, weighted
  metropolis,  ///< adaptive Metropolis
};

constexpr std::string_view name(PosteriorMethod method) {
  constexpr std::array<std::string_view, 4> names{"auto", "laplace", "importance", "metropolis"};
  return names[static_cast<std::size_t>(method)];
}

struct PosteriorOptions {
  PosteriorMethod method = PosteriorMethod::automatic;
  std::uint64_t seed = 1;
  /// 50 or more; metropolis: three halves of it in each of four chains. 0: as many as some seconds allow,
  /// 8000 for a few shots, down to 1500.
  int draws = 0;
  sampling::Progress progress{};
};

using FreeParameters = std::array<bool, kParameterCount>;

struct FitOptions {
  ReboundModel model = ReboundModel::grip_offset;
  double diameter_m = ball::kThesisDiameter_m;
  ParameterValues start = default_values(ReboundModel::grip_offset);  ///< or fixed value
  FreeParameters free{true, true, true, true, false};  ///< none free: the model is evaluated at `start`
  Weighting weighting = Weighting::equal;
  CovarianceScale scale = CovarianceScale::clustered;
  double vx_weight = 1.0;        ///< of a squared residual of vx; > 0. Only with Weighting::equal.
  double spin_weight = 1.0;      ///< of a squared residual of R·omega
  PosteriorOptions posterior{};  ///< of ode
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
  /// ode: the data hardly tell it, the prior does (kUntoldShare), or they tell fewer combinations than
  /// parameters, and others better. Others: nothing changes with it at the minimum; or mu, where noise alone
  /// may explain that a contact seems to slide: all may grip (likelihood ratio below that of 3.5 sd); or e_x,
  /// where all may slide. `limit` is then the lower end of a one-sided interval of kLimitLevel, and the value
  /// the one with the least chi2.
  undetermined,
};

constexpr std::string_view name(ParameterStatus status) {
  constexpr std::array<std::string_view, 5> names{"fixed", "fitted", "at lower bound", "at upper bound",
                                                  "undetermined"};
  return names[static_cast<std::size_t>(status)];
}

inline constexpr double kLimitLevel = 0.95;     ///< of the one-sided intervals
inline constexpr double kIntervalLevel = 0.95;  ///< of the two-sided intervals

struct FittedParameter {
  double value = 0.0;
  ParameterStatus status = ParameterStatus::fixed;
  /// Fitted only. With CovarianceScale::clustered scaled by Student's t, so that it holds 68 % of the
  /// deviations.
  std::optional<double> sd;
  std::optional<double> limit;  ///< see ParameterStatus
  /// The interval of kIntervalLevel where fitted (profile_interval()): an end is absent where nothing speaks
  /// against any value up to the parameter's bound. Else one end is the limit.
  std::optional<double> lower;
  std::optional<double> upper;
  std::optional<double> degrees_of_freedom;  ///< of Student's t in sd, limit and interval
};

/// The sd of a coordinate over its prior's above which the data are said not to tell the parameter.
inline constexpr double kUntoldShare = 0.7;
/// Correlation of two coordinates from which only a combination of the two is said to be told.
inline constexpr double kTiedCorrelation = 0.85;

/// Of the parameters that are free, in the coordinates of rebound_model.hpp.
struct Posterior {
  PosteriorMethod method = PosteriorMethod::laplace;  ///< that the intervals are from
  std::uint64_t seed = 0;
  sampling::Sample sample;             ///< none by laplace
  double effective_size = 0.0;         ///< independent draws that it is worth
  std::optional<double> pareto_shape;  ///< of importance sampling
  std::optional<double> r_hat;         ///< of metropolis, the worst
  std::optional<double> acceptance;
  bool reliable = false;
  int evaluations = 0;         ///< of the density
  double laplace_shift = 0.0;  ///< largest of an interval's end from the Laplace approximation's, sds
  std::vector<Parameter> parameters;
  std::vector<double> medians;       ///< of the values
  std::vector<double> prior_shares;  ///< sd of the coordinate over that of its prior
  std::vector<double> coordinate_sds;
  Eigen::MatrixXd correlation;
};

struct ModelFit {
  std::array<FittedParameter, kParameterCount> parameters;
  /// Of all parameters, in their units; rows and columns of those that are not `fitted` are 0.
  Eigen::Matrix<double, kParameterCount, kParameterCount> covariance;
  double chi2 = 0.0;  ///< weighted sum of squares; (m/s)² with Weighting::equal
  int clusters =
      0;  ///< shots, or the series where these scatter: what CovarianceScale::clustered takes as independent
  int dof = 0;  ///< two per observation, less the free parameters
  double variance_scale =
      1.0;  ///< chi2/dof: factor of the covariance with CovarianceScale::residuals; 1 with stated
  /// What the sds are from: as asked for, but `stated` where the observations scatter less than their sds let
  /// expect once in fifty fits (least_likely_chi2()). The residuals are then no measure of the noise.
  CovarianceScale covariance_scale = CovarianceScale::clustered;
  Termination termination = Termination::iteration_limit;  ///< of the search
  std::vector<Comparison> comparisons;                     ///< one for each observation, in order
  ResidualStatistics statistics;
  std::optional<Posterior> posterior;  ///< of ode

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

// Checks of the inputs of fit(). Pure; thread-safe.

/// What is wrong with one observation: invalid_observation (no impact has such numbers) or invalid_sd. `at`:
/// its place, for the failure. Returns nullopt if nothing is.
std::optional<FitFailure> find_observation_failure(const Observation& observation, std::size_t at,
                                                   const FitOptions& options);

// Leave-one-group-out cross-validation of the rebound models: each group of observations is predicted by a
// fit of the others. Deterministic; thread-safe; allocates; one fit per group.

enum class CrossValidationGroup {
  spin,    ///< all observations of one spin
  series,  ///< all observations of one series: a condition, or the shots of a series
};

struct HeldOutGroup {
  std::string group;
  std::vector<std::size_t> observations;  ///< their indices
  ModelFit fit;                           ///< of the others
  std::vector<Comparison> predicted;      ///< the group compared with that fit
  ResidualStatistics statistics;          ///< of `predicted`
};

struct CrossValidation {
  std::vector<HeldOutGroup> groups;  ///< in order of first appearance
  ResidualStatistics statistics;     ///< over all groups: each observation is predicted once
};

/// Errors as for fit(), of all observations or of those without a group; underdetermined if there is only one
/// group.
tl::expected<CrossValidation, FitFailure> leave_one_group_out(std::span<const Observation> observations,
                                                              const FitOptions& options,
                                                              CrossValidationGroup by);

/// The observations of one spin.
std::vector<Observation> of_spin(std::span<const Observation> observations, std::string_view spin);

}  // namespace strobe::impact
