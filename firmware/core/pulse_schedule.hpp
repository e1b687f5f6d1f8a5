// From a shot's plan to pulses at instants. Offsets are relative to the shot's start; the first is 0.
#pragma once

#include <vector>

#include "common/result.hpp"
#include "common/shot/plan_check.hpp"
#include "firmware/core/rig.hpp"
#include "firmware/ports/output_lines.hpp"

namespace strobe::firmware {

/// One pulse of an output. It ends `width` after it was issued, so that a late one is never cut short.
struct PlannedPulse {
  Duration at{};
  Output output = Output::strobes;
  Duration width{};
  std::int32_t flash_index = -1;  ///< strobes only
  Lamps lamps = Lamps::both;      ///< strobes only
};

struct PulseSchedule {
  std::vector<PlannedPulse> pulses;  ///< sorted by `at`; capacity from reserve(), never exceeded
  Duration exposure_begin{};         ///< the shutter is open from here ...
  Duration exposure_end{};           ///< ... to here
  std::int32_t flash_count = 0;      ///< free: in `pulses`; gated: of the burst
  Duration shortest_interval{};      ///< between two flashes
  bool gated = false;

  void reserve(std::int32_t max_flashes) { pulses.reserve(static_cast<std::size_t>(max_flashes) + 2); }
};

/// Any two flashes must be further apart than this, so that a pulse is over before the next one and the loop
/// reads the e-stop in between.
Duration min_flash_interval(const Rig& rig);

PlanLimits plan_limits(const Rig& rig);

/// Fails, naming the limit, if the plan exceeds the rig's limits or contradicts itself. Allocates.
Result<void> check_plan(const ShotPlan& plan, const Rig& rig);

/// The pulses of a checked plan. Real-time safe once `schedule` has its capacity.
void build_schedule(const ShotPlan& plan, const Rig& rig, PulseSchedule& schedule) noexcept;

/// Gated: adds the burst whose first flash is due at `first`. Returns false, and adds nothing, if it would
/// not end within the exposure. Real-time safe.
bool add_burst(const ShotPlan& plan, const Rig& rig, Duration first, PulseSchedule& schedule) noexcept;

}  // namespace strobe::firmware
