// The worker: takes the lines, starts the loop, the publisher and the receiver, and ends them in order.
#pragma once

#include "firmware/core/rig.hpp"
#include "firmware/linux/guardian.hpp"
#include "firmware/options.hpp"

namespace strobe::firmware {

/// Returns the exit status once a stop signal came (0), or at once if something is missing (2, one line on
/// stderr).
int run_worker(const Rig& rig, const Options& options, SharedStatus& page);

}  // namespace strobe::firmware
