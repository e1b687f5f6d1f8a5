// What a dry train says of a lamp and its sensor. Pure; allocates; thread-safe.
#pragma once

#include <strobe_msgs/shot_t.hpp>

#include "common/shot/lamps.hpp"
#include "host/commission/core/step_result.hpp"
#include "host/config/commission_table.hpp"

namespace strobe::commission {

/// A train of one lamp alone (a or b): its own sensor must see each flash once, at the rig file's delay, and the other
/// sensor none. Delay and jitter fail where they are beyond their limits by more than chance gives once in a thousand rigs.
StepResult judge_lamp_alone(const std::string& id, Lamps lamp, const strobe_msgs::shot_t& shot,
                            const host::CommissionTable& limits);

/// A train of both lamps: each sensor sees each flash, and the lamps flash together.
StepResult judge_lamps_together(const std::string& id, const strobe_msgs::shot_t& shot,
                                const host::CommissionTable& limits);

}  // namespace strobe::commission
