#include "common/impact/fit/model_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/impact/fit/contact_posterior.hpp"
#include "common/impact/fit/fitter.hpp"
#include "common/impact/fit/uncertainty.hpp"

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

namespace {

/// The first error found. Returns nullopt if there is none.
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

Fitter least_squares(std::span<const Observation> observations, const FitOptions& options) {
  Fitter fitter(observations, options);
  options.model == ReboundModel::ode ? fitter.search_with_prior() : fitter.search();
  return fitter;
}

/// Zero scatter is not zero noise. Where the conditions scatter, it is their scatter that the sds are from.
bool scatters_too_little(const Fitter& fitter) {
  const FitOptions& o = fitter.options();
  if (o.weighting != Weighting::stated_sd || o.scale == CovarianceScale::stated || fitter.scatters())
    return false;
  return fitter.chi2() < least_likely_chi2(fitter.degrees_of_freedom());
}

}  // namespace

tl::expected<ModelFit, FitFailure> fit(std::span<const Observation> observations, const FitOptions& asked) {
  if (const auto failure = find_failure(observations, asked)) return tl::unexpected(*failure);
  FitOptions options = asked;
  Fitter fitter = least_squares(observations, options);
  if (scatters_too_little(fitter)) {
    options.scale = CovarianceScale::stated;
    fitter = least_squares(observations, options);
  }
  const bool has_prior = options.model == ReboundModel::ode;
  ModelFit out;
  out.covariance_scale = options.scale;
  out.termination = fitter.termination();
  out.comparisons = compare(observations, options.model, fitter.values(), options.diameter_m);
  out.statistics = residual_statistics(out.comparisons);
  out.chi2 = fitter.chi2();
  out.clusters = static_cast<int>(fitter.clusters().size());
  out.dof = fitter.degrees_of_freedom();
  if (options.scale != CovarianceScale::stated) out.variance_scale = fitter.reduced(out.chi2, out.dof);
  out.covariance.setZero();
  for (std::size_t i = 0; i < kParameterCount; ++i) out.parameters[i].value = fitter.values()[i];
  if (has_prior) {
    add_posterior(fitter, out);
    return out;
  }
  if (const auto added = add_uncertainty(fitter, out); !added) return tl::unexpected(added.error());
  return out;
}

FitOptions default_options(ReboundModel model) {
  FitOptions out{.model = model, .start = default_values(model), .free = {}};
  if (model == ReboundModel::ode) {
    for (std::size_t i = 0; i < kParameterCount; ++i)
      out.free[i] = has_parameter(model, static_cast<Parameter>(i));
    return out;
  }
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
  const auto i = static_cast<Eigen::Index>(index(a));
  const auto j = static_cast<Eigen::Index>(index(b));
  const double scale = std::sqrt(covariance(i, i)) * std::sqrt(covariance(j, j));
  return scale > 0.0 ? covariance(i, j) / scale : 0.0;
}

namespace {

const std::string& group_of(const Observation& o, CrossValidationGroup by) {
  return by == CrossValidationGroup::spin ? o.spin : o.series;
}

std::vector<std::string> groups_of(std::span<const Observation> observations, CrossValidationGroup by) {
  std::vector<std::string> out;
  for (const Observation& o : observations)
    if (std::find(out.begin(), out.end(), group_of(o, by)) == out.end()) out.push_back(group_of(o, by));
  return out;
}

/// Of a posterior only the mode is used.
FitOptions without_sample(FitOptions options) {
  options.posterior.method = PosteriorMethod::laplace;
  return options;
}

tl::expected<HeldOutGroup, FitFailure> hold_out(const std::string& group,
                                                std::span<const Observation> observations,
                                                const FitOptions& options, CrossValidationGroup by) {
  HeldOutGroup out;
  out.group = group;
  std::vector<Observation> kept, left;
  std::vector<std::size_t> kept_from;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const bool leave = group_of(observations[i], by) == group;
    (leave ? left : kept).push_back(observations[i]);
    (leave ? out.observations : kept_from).push_back(i);
  }
  auto fitted = fit(kept, without_sample(options));
  if (!fitted) {
    FitFailure failure = fitted.error();
    if (failure.observation < kept_from.size()) failure.observation = kept_from[failure.observation];
    return tl::unexpected(failure);
  }
  out.predicted = compare(left, options.model, fitted->values(), options.diameter_m);
  out.statistics = residual_statistics(out.predicted);
  out.fit = *std::move(fitted);
  return out;
}

}  // namespace

tl::expected<CrossValidation, FitFailure> leave_one_group_out(std::span<const Observation> observations,
                                                              const FitOptions& options,
                                                              CrossValidationGroup by) {
  // Errors of the observations themselves are reported before any group is left out.
  if (const auto whole = fit(observations, without_sample(options)); !whole)
    return tl::unexpected(whole.error());
  const std::vector<std::string> groups = groups_of(observations, by);
  if (groups.size() < 2) return tl::unexpected(FitFailure{.error = FitError::underdetermined});
  CrossValidation out;
  std::vector<Comparison> all;
  for (const std::string& group : groups) {
    auto left = hold_out(group, observations, options, by);
    if (!left) return tl::unexpected(left.error());
    all.insert(all.end(), left->predicted.begin(), left->predicted.end());
    out.groups.push_back(*std::move(left));
  }
  out.statistics = residual_statistics(all);
  return out;
}

std::vector<Observation> of_spin(std::span<const Observation> observations, std::string_view spin) {
  std::vector<Observation> out;
  for (const Observation& o : observations)
    if (o.spin == spin) out.push_back(o);
  return out;
}

}  // namespace strobe::impact
