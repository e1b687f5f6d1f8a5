// The worker process: opens the ports, runs the loop, the publisher and the receiver, ends them in order.
#pragma once

#include "firmware/core/rig.hpp"
#include "firmware/linux/guardian.hpp"
#include "firmware/worker/options.hpp"
#include "firmware/worker/rig_device.hpp"

namespace strobe::firmware {

/// Runs until a stop signal and returns 0, or 1 if the outputs could not be made safe. Returns 2 at once,
/// with one line on stderr, if something is missing.
int run_worker(const Rig& rig, const Options& options, SharedStatus& page, RigDevice& device);

}  // namespace strobe::firmware
