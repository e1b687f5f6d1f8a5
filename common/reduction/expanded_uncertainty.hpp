// The uncertainty that can be stated beside a number: GUM's combined and expanded uncertainty. Pure; thread-safe.
#pragma once

#include <optional>

#include "common/reduction/readout.hpp"

namespace strobe::reduction {

inline constexpr double kExpandedLevel = 0.95;

/// Noise and what tolerances add, as one standard deviation. Absent without an sd.
std::optional<double> total_sd(const Readout& readout, Quantity quantity);

/// Half width of the interval that holds the true number with a probability of kExpandedLevel: noise, with Student's t
/// where it was estimated, and what tolerances add. Of few residuals it is far more than twice the sd, which holds
/// 68.27 %. nullopt without an sd, as with estimator "legacy".
/// Source: JCGM 100:2008 (GUM), 6.2.1 and G.4.
std::optional<double> expanded_uncertainty(const Readout& readout, Quantity quantity);

}  // namespace strobe::reduction
