// From a shot's plan to pulses at instants.
#pragma once

#include "common/result.hpp"
#include "common/shot/plan_check.hpp"
#include "firmware/core/rig.hpp"
#include "firmware/ports/scheduled_outputs.hpp"

namespace strobe::firmware {

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
