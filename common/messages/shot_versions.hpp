// Shots of logs from before their present version. Pure; allocates; thread-safe.
#pragma once

#include <strobe_msgs/shot_t.hpp>
#include <strobe_msgs/shot_v1_t.hpp>

namespace strobe::messages {

/// All flashes were of both lamps, which had one delay; there was no feedback of the shutter.
strobe_msgs::shot_t shot_from_v1(const strobe_msgs::shot_v1_t& message);

}  // namespace strobe::messages
