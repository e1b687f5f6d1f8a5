// Leave-one-group-out cross-validation of the rebound models: each group of observations is predicted by a
// fit of the others. Deterministic; thread-safe; allocates; one fit per group.
#pragma once

#include "common/impact/fit/model_fit.hpp"

namespace strobe::impact {

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
