#include "common/impact/fit/cross_validation.hpp"

#include <algorithm>

namespace strobe::impact {

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
