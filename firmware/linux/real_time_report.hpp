// `strobed --check` on the machine's real-time set-up: rights, power saving, what else may run on the loop's
// CPU, the clock. Set-up only, not real-time.
#pragma once

#include <string>
#include <vector>

#include "firmware/core/rig.hpp"
#include "firmware/core/tick.hpp"
#include "firmware/linux/check_item.hpp"
#include "firmware/linux/real_time.hpp"
#include "firmware/linux/system_files.hpp"

namespace strobe::firmware {

/// policy, priority, memory, pinning, latency, tick, governor, throttling, isolation, preemption, interrupts,
/// fixed_interrupts, clock_source, in this order.
std::vector<CheckItem> real_time_report(const Rig& rig, const RealTimeRights& trial, const Tick& tick,
                                        const SystemFiles& files);

}  // namespace strobe::firmware
