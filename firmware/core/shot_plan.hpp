// What is asked for (PlanRequest) to pulses at instants. Offsets are relative to the shot's start, the first
// is 0.
#pragma once

#include <vector>

#include "common/result.hpp"
#include "firmware/core/rig.hpp"
#include "firmware/ports/output_lines.hpp"

namespace strobe::firmware {

inline constexpr std::int32_t kMaxFlashes = 4000;  ///< of any rig; sizes what is allocated at the start

/// One pulse of an output. Its end is `width` after it was really issued, so that a late one is never cut
/// short.
struct PlannedPulse {
  Duration at{};
  Output output = Output::strobes;
  Duration width{};
  std::int32_t flash_index = -1;  ///< strobes only
  Lamps lamps = Lamps::both;      ///< strobes only
};

struct ShotPlan {
  std::vector<PlannedPulse> pulses;  ///< sorted by `at`; capacity from reserve(), never exceeded
  Duration exposure_begin{};         ///< the shutter is open from here ...
  Duration exposure_end{};           ///< ... to here
  std::int32_t flash_count = 0;      ///< free: those in `pulses`; gated: those that the gate will start
  Duration shortest_interval{};      ///< between two flashes
  bool gated = false;

  void reserve(std::int32_t max_flashes) { pulses.reserve(static_cast<std::size_t>(max_flashes) + 2); }
};

/// Two flashes of whichever lamps must be further apart than this, so that a pulse is over before the next
/// one, and the loop looks at the e-stop in between.
Duration min_flash_interval(const Rig& rig);

/// Refuses, in words that name the limit, what exceeds the rig's limits or contradicts itself. Allocates.
Result<void> check_plan(const PlanRequest& request, const Rig& rig);

/// Flashes of a checked plan.
std::int32_t flash_count(const PlanRequest& request);

/// The pulses of a checked plan. Real-time safe once `plan` has its capacity.
void build_plan(const PlanRequest& request, const Rig& rig, ShotPlan& plan) noexcept;

/// Gated: adds the burst whose first flash is due at `first`. Real-time safe.
/// False: it would not end within the exposure; nothing is added.
bool add_burst(const PlanRequest& request, const Rig& rig, Duration first, ShotPlan& plan) noexcept;

}  // namespace strobe::firmware
