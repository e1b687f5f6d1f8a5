// The kernel's timer tick, found from how it interrupts a thread that spins.
//
// Every CPU that is awake is interrupted at each tick (CONFIG_HZ: 100 to 1000 a second) for some
// microseconds, at multiples of one period on CLOCK_MONOTONIC, and on all CPUs at once. A pulse that is due
// within that time is late by what is left of it; only the kernel's option nohz_full takes the tick away. So
// the tick is looked for at the start, and shots begin so that their flashes fall between ticks
// (quiet_start.hpp).
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

/// Two readings of the clock, one right after the other, that lie apart.
struct Gap {
  MonoTime at;  ///< the first reading
  Duration length{};
};

/// The tick of a given period in a spin over so many periods; unknown if fewer than three in five of them
/// were interrupted at one phase (within 40 us). Allocates.
Tick detect_tick(std::span<const Gap> gaps, Duration period, int periods);

}  // namespace strobe::firmware
