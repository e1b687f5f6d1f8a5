// Status messages of logs from before version 2. Pure; thread-safe; allocates.
#pragma once

#include <strobe_msgs/status_t.hpp>
#include <strobe_msgs/status_v1_t.hpp>

namespace strobe::messages {

/// The lateness is the only histogram, without mean, sd and bins. CLOCK_BOOTTIME is taken to be
/// CLOCK_MONOTONIC: of suspensions nothing is known.
strobe_msgs::status_t status_from_v1(const strobe_msgs::status_v1_t& old);

}  // namespace strobe::messages
