// Checks of the inputs of fit(). Pure; thread-safe.
#pragma once

#include <optional>

#include "common/impact/fit/model_fit.hpp"

namespace strobe::impact {

/// The first error found. Returns nullopt if there is none.
std::optional<FitFailure> find_failure(std::span<const Observation> observations, const FitOptions& options);

}  // namespace strobe::impact
