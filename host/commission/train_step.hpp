// What dry trains say of lamps and their sensors, and of the shutter by its contact. Pure; allocates;
// thread-safe.
#pragma once

#include <span>
#include <strobe_msgs/shot_t.hpp>

#include "common/shot/shot_plan.hpp"
#include "host/commission/record/step_result.hpp"
#include "host/config/rig_file.hpp"

namespace strobe::commission {

/// A train of one lamp alone (a or b): its own sensor must see each flash once, at the rig file's delay, and
/// the other sensor none. Delay and jitter fail where they are beyond their limits by more than chance gives
/// once in a thousand rigs.
StepResult judge_lamp_alone(Lamps lamp, const strobe_msgs::shot_t& shot, const host::CommissionTable& limits);

/// A train of both lamps: each sensor sees each flash, and the lamps flash together.
StepResult judge_lamps_together(const strobe_msgs::shot_t& shot, const host::CommissionTable& limits);

/// Opening and closing must each come within the tolerance of the rig file's lag. Skipped where the shutter
/// has no contact.
StepResult judge_shutter(std::span<const strobe_msgs::shot_t> shots, const host::RigFile& rig);

}  // namespace strobe::commission
