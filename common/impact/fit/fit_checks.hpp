// What fit() demands of its inputs. Pure; thread-safe.
#pragma once

#include <optional>

#include "common/impact/fit/model_fit.hpp"

namespace strobe::impact {

/// The first thing that is wrong, if anything is.
std::optional<FitFailure> find_failure(std::span<const Observation> observations, const FitOptions& options);

}  // namespace strobe::impact
