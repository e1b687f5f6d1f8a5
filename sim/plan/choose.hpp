// The model for a shot that is to be exact to a tolerance and done within a time.
// Deterministic but for the measured costs, which decide only what has a deadline. Allocates.
#pragma once

#include <optional>
#include <string>

#include "common/result.hpp"
#include "sim/plan/plan.hpp"

namespace strobe::sim {

struct PlanRequirement {
  std::optional<double> tolerance;    ///< relative, above 0, at most 1
  std::optional<double> deadline_us;  ///< > 0; of computing one shot, on this machine as it is now
};

struct ChosenPlan {
  Plan plan;
  double tolerance = 0.0;         ///< what it was planned for
  std::optional<double> cost_us;  ///< if there was a deadline
};

/// The plan of the tolerance. With a deadline alone the plan of the smallest of kLadder's tolerances that
/// meets it. Without either the full model would do: at least one must be there. The error, where nothing
/// meets both, names the nearest possible: what the tolerance takes and what is reached in the time.
Result<ChosenPlan> choose(const Scene& scene, const PlanRequirement& demand, const ShootSettings& settings);

/// 1, 2, 5 times powers of ten from 1e-5 to 1.
inline constexpr std::array<double, 16> kLadder{1e-5, 2e-5, 5e-5, 1e-4, 2e-4, 5e-4, 1e-3, 2e-3,
                                                5e-3, 1e-2, 2e-2, 5e-2, 0.1,  0.2,  0.5,  1.0};

/// For people, one line: what is left out, by how much each of it can change what, and all of it together.
std::string explanation(const ChosenPlan& chosen);

}  // namespace strobe::sim
