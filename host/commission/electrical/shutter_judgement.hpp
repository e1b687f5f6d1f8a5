// What dry shots say of the shutter, by its contact. Pure; allocates; thread-safe.
#pragma once

#include <span>
#include <string>
#include <strobe_msgs/shot_t.hpp>

#include "host/commission/core/step_result.hpp"
#include "host/config/rig_file.hpp"

namespace strobe::commission {

/// Opening and closing must each come within the tolerance of the rig file's lag. Skipped where the shutter has no contact.
StepResult judge_shutter(const std::string& id, std::span<const strobe_msgs::shot_t> shots,
                         const host::RigFile& rig);

}  // namespace strobe::commission
