// Lift-offs of contacts in 34 digits (Boost.Multiprecision, Boost.odeint). Allocates, runs threads.
#pragma once

#include <vector>

#include "tests/studies/trade/calibration.hpp"

namespace strobe::studies::trade {

/// The scenes with their lift-off.
std::vector<KnownImpact> known_impacts(const std::vector<ImpactScene>& scenes);

/// The reference's own error as lift_off_error: its change with half the step, largest of the first `most`
/// scenes.
double reference_error(const std::vector<ImpactScene>& scenes, std::size_t most);

}  // namespace strobe::studies::trade
