// Measures the kernel's timer tick by spinning for some 60 ms. Set-up only.
#pragma once

#include "firmware/core/rig.hpp"
#include "firmware/core/tick.hpp"

namespace strobe::firmware {

/// In a thread of its own with the loop's priority and CPU, as far as they are granted. Unknown if the tick
/// does not reach that CPU (nohz_full), is shorter than 1 us, or too much else interrupts it.
Tick find_tick(const Rig::RealTime& wanted);

}  // namespace strobe::firmware
