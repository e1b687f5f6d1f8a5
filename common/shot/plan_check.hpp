// Whether a rig can play a plan: the limits of its lamps, shutter and loop. The workstation checks before it
// arms, the firmware each FIRE. Pure; allocates; thread-safe.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "common/shot/shot_plan.hpp"

namespace strobe {

inline constexpr std::int32_t kMaxFlashes = 4000;  ///< of any rig; sizes what is allocated at the start
/// Of any duration in a plan: keeps sums of a hostile one far from overflow.
inline constexpr Duration kLongestOfPlan = std::chrono::hours{1};

/// Of a rig, as its rig file has them. Without values: of one that can all that a plan can say.
struct PlanLimits {
  Duration lamp_period{};     ///< between two flashes of a lamp: lamps.min_period_us
  Duration lamp_pulse{};      ///< lamps.pulse_us
  Duration flash_interval{};  ///< any two flashes are further apart: lamps.max_on_us and tolerance.spin_us
  std::int32_t max_flashes = kMaxFlashes;      ///< of a shot: lamps.max_flashes_per_shot
  Duration longest_exposure = kLongestOfPlan;  ///< shutter.max_open_s
  bool gate_fitted = true;                     ///< lines.gate
  Duration impact_at{};                        ///< of plans that have none: plan.impact_at_ms
};

struct PlanProblem {
  const char* field = "";  ///< of a plan file, e.g. "period_us"
  std::string what;        ///< which limit, and by how much
};

/// The first thing that exceeds the limits or contradicts itself; nullopt: the rig can play it.
std::optional<PlanProblem> plan_problem(const ShotPlan& plan, const PlanLimits& limits);

/// Number of flashes of a plan; of one that is too long kMaxFlashes + 1.
std::int32_t flash_count(const ShotPlan& plan);

}  // namespace strobe
