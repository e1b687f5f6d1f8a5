// Chooses the model for a tolerance of the readout and a deadline for computing a shot.
// Deterministic but for the measured costs, which matter only with a deadline. Allocates.
#pragma once

#include <optional>
#include <string>

#include "common/result.hpp"
#include "sim/plan/plan.hpp"

namespace strobe::sim {

struct PlanRequirement {
  std::optional<double> tolerance;    ///< relative, above 0, at most 1
  std::optional<double> deadline_us;  ///< > 0; time to compute one shot, measured on this machine now
};

struct ChosenPlan {
  Plan plan;
  double tolerance = 0.0;         ///< the plan's
  std::optional<double> cost_us;  ///< per shot; only with a deadline
};

/// The plan for the tolerance. With a deadline alone the plan for the smallest of kLadder's tolerances that
/// meets it. At least one must be given. If no plan meets both, the error names the nearest: the time that
/// the tolerance needs and the tolerance that the time allows.
Result<ChosenPlan> choose(const Scene& scene, const PlanRequirement& demand, const ShootSettings& settings);

/// 1, 2, 5 times powers of ten from 1e-5 to 1.
inline constexpr std::array<double, 16> kLadder{1e-5, 2e-5, 5e-5, 1e-4, 2e-4, 5e-4, 1e-3, 2e-3,
                                                5e-3, 1e-2, 2e-2, 5e-2, 0.1,  0.2,  0.5,  1.0};

/// One line of text: the effects left out, how much each can change which quantity, and all of them together.
std::string explanation(const ChosenPlan& chosen);

}  // namespace strobe::sim
