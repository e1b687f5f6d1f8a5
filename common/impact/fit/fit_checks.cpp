#include "common/impact/fit/fit_checks.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace strobe::impact {

namespace {

bool positive(double x) { return x >= kMinMagnitude && x <= kMaxMagnitude; }
/// An sd of 0 means unknown.
bool is_sd(double x) { return x == 0.0 || positive(x); }
bool in_range(double x) { return std::abs(x) <= kMaxMagnitude; }

bool are_sds(const Motion& sd) { return is_sd(sd.vx_mps) && is_sd(sd.vy_mps) && is_sd(sd.omega_radps); }

std::optional<FitFailure> find_option_failure(const FitOptions& o) {
  if (!positive(o.diameter_m) || !positive(o.vx_weight) || !positive(o.spin_weight))
    return FitFailure{.error = FitError::invalid_options};
  for (std::size_t i = 0; i < kParameterCount; ++i) {
    const auto p = static_cast<Parameter>(i);
    if (!has_parameter(o.model, p)) {
      if (o.free[i]) return FitFailure{.error = FitError::parameter_not_in_model, .parameter = p};
      continue;
    }
    const bool inside = o.start[i] >= lower_bound(p) && o.start[i] <= upper_bound(p, 0.5 * o.diameter_m);
    if (!inside) return FitFailure{.error = FitError::value_out_of_bounds, .parameter = p};
  }
  return std::nullopt;
}

std::string text_of(FitError error) {
  constexpr std::array<const char*, 8> texts{
      "there are no observations to fit to",
      "invalid observation",
      "standard deviations must be finite and not negative, those of lift-off positive where they weight the "
      "fit",
      "diameter and weights must be positive",
      "the model does not have this parameter",
      "outside of the parameter's range",
      "too few observations for so many parameters: each gives two numbers (vx and omega)",
      "cannot be separated from the other parameters by these observations: fix it"};
  return texts[static_cast<std::size_t>(error)];
}

}  // namespace

std::optional<FitFailure> find_observation_failure(const Observation& o, std::size_t at,
                                                   const FitOptions& options) {
  const auto predicted = rebound_of(options.model, options.start, options.diameter_m, inputs_of(o));
  FitFailure failure{.error = FitError::invalid_observation, .observation = at};
  if (!predicted) {
    failure.input = predicted.error();
    return failure;
  }
  if (!in_range(o.lift_off.vx_mps) || !in_range(o.lift_off.omega_radps)) return failure;
  failure.error = FitError::invalid_sd;
  if (!are_sds(o.touchdown_sd) || !are_sds(o.lift_off_sd) || !is_sd(o.e_sd) || !is_sd(o.dwell_sd_s))
    return failure;
  if (moved_inputs_error(options.model, options.start, options.diameter_m, o)) return failure;
  const bool no_weight = o.lift_off_sd.vx_mps == 0.0 || o.lift_off_sd.omega_radps == 0.0;
  if (options.weighting == Weighting::stated_sd && no_weight) return failure;
  return std::nullopt;
}

std::optional<FitFailure> find_failure(std::span<const Observation> observations, const FitOptions& options) {
  if (observations.empty()) return FitFailure{.error = FitError::no_observations};
  if (const auto failure = find_option_failure(options)) return failure;
  for (std::size_t i = 0; i < observations.size(); ++i)
    if (const auto failure = find_observation_failure(observations[i], i, options)) return failure;
  const auto parameters =
      static_cast<std::size_t>(std::count(options.free.begin(), options.free.end(), true));
  const std::size_t spare = options.scale != CovarianceScale::stated && parameters > 0 ? 1 : 0;
  if (2 * observations.size() < parameters + spare) return FitFailure{.error = FitError::underdetermined};
  return std::nullopt;
}

std::string message(const FitFailure& failure, std::span<const Observation> observations) {
  const auto at = [&] {
    return failure.observation < observations.size() ? observations[failure.observation].name + ": " : "";
  };
  switch (failure.error) {
    case FitError::invalid_observation:
      return at() + std::string(message(failure.input));
    case FitError::invalid_sd:
      return at() + text_of(failure.error);
    case FitError::parameter_not_in_model:
    case FitError::value_out_of_bounds:
    case FitError::not_identifiable:
      return std::string(name(failure.parameter)) + ": " + text_of(failure.error);
    default:
      return text_of(failure.error);
  }
}

}  // namespace strobe::impact
