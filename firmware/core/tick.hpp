// The kernel's timer tick, detected from how it interrupts a spinning thread.
//
// Each tick (CONFIG_HZ: 100 to 1000 a second) interrupts every CPU that is awake for some microseconds, at
// multiples of one period of CLOCK_MONOTONIC. A pulse due within that time is late by the rest of it; only
// the kernel's option nohz_full avoids this. So the tick is measured at the start, and shots begin so that
// their flashes fall between ticks (tick_avoidance.hpp).
#pragma once

#include <span>

#include "common/units/time.hpp"

namespace strobe::firmware {

struct Tick {
  Duration period{};  ///< 0: none is known
  Duration phase{};   ///< begins at phase + k * period, 0 <= phase < period
  Duration length{};  ///< of the interruption, nine in ten are shorter

  bool known() const noexcept { return period > Duration{}; }
};

/// Two consecutive readings of the clock that are far apart: the thread was interrupted.
struct Gap {
  MonoTime at;  ///< the first reading
  Duration length{};
};

/// The tick of a given period in a spin over so many periods. Unknown if fewer than three in five of them
/// were interrupted at the same phase (within 40 us). Allocates.
Tick detect_tick(std::span<const Gap> gaps, Duration period, int periods);

}  // namespace strobe::firmware
