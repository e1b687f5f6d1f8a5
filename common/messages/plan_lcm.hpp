// Shot plans to and from their LCM message. Pure functions; thread-safe; plan_to_lcm allocates.
#pragma once

#include <strobe_msgs/plan_t.hpp>

#include "common/shot/shot_plan.hpp"

namespace strobe::messages {

strobe_msgs::plan_t plan_to_lcm(const ShotPlan& plan);
/// Of a code longer than kMaxCodedFlashes only the first part (well_formed() refuses it before).
ShotPlan plan_from_lcm(const strobe_msgs::plan_t& message);

}  // namespace strobe::messages
