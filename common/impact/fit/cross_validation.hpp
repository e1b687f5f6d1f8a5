// Validation of the in/out models on what they were not fitted to: the fit leaves a group of observations out
// and predicts it. Deterministic; thread-safe; allocates; a fit for each group.
#pragma once

#include "common/impact/fit/model_fit.hpp"

namespace strobe::impact {

enum class LeaveOut {
  spin,    ///< all observations of one spin
  series,  ///< all of one series: one of the conditions, or all shots of one series of shots
};

struct LeftOut {
  std::string group;
  std::vector<std::size_t> observations;  ///< indices of those left out
  ModelFit fit;                           ///< of the others
  std::vector<Comparison> predicted;      ///< those left out against that fit
  Agreement agreement;                    ///< of `predicted`
};

struct Validation {
  std::vector<LeftOut> groups;  ///< in order of first appearance
  Agreement agreement;          ///< over all predictions: each observation was predicted once
};

/// Failures as for fit(), where the others do not suffice; too_few_numbers if there is only one group.
tl::expected<Validation, FitFailure> leave_out(std::span<const Observation> observations,
                                               const FitOptions& options, LeaveOut by);

/// The observations of one spin, to fit and validate a spin by itself.
std::vector<Observation> of_spin(std::span<const Observation> observations, std::string_view spin);

}  // namespace strobe::impact
