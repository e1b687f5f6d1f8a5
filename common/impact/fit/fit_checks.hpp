// Checks of the inputs of fit(). Pure; thread-safe.
#pragma once

#include <optional>

#include "common/impact/fit/model_fit.hpp"

namespace strobe::impact {

/// What is wrong with one observation: invalid_observation (no impact has such numbers) or invalid_sd. `at`: its place,
/// for the failure. Returns nullopt if nothing is.
std::optional<FitFailure> find_observation_failure(const Observation& observation, std::size_t at,
                                                   const FitOptions& options);

/// The first error found. Returns nullopt if there is none.
std::optional<FitFailure> find_failure(std::span<const Observation> observations, const FitOptions& options);

}  // namespace strobe::impact
