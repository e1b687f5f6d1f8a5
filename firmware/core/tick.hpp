// The kernel's timer tick, detected from how it interrupts a spinning thread.
//
// Each tick (CONFIG_HZ: 100 to 1000 a second) interrupts every CPU that is awake for some microseconds, at
// multiples of one period of CLOCK_MONOTONIC. A pulse due within that time is late by the rest of it; only
// the kernel's option nohz_full avoids this. So the tick is measured at the start, and shots begin so that
// their flashes fall between ticks (TickAvoidance).
#pragma once

#include <array>
#include <span>

#include "common/units/time.hpp"
#include "firmware/core/pulse_schedule.hpp"

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

/// Chooses a shot's start within one period of the kernel's timer tick so that its flashes fall between
/// ticks.
///
/// If the periods of train and tick have a large common divisor (3 ms and 4 ms: 1 ms), it depends on the
/// start whether one flash in a few meets the tick, or none. Other trains lose nothing. The ball times a
/// gated burst: it is not moved. Real-time safe (some 20 us a call), one thread's.
class TickAvoidance {
 public:
  explicit TickAvoidance(const Tick& tick) noexcept;

  /// How much later than `earliest` the schedule's first instant should be: less than one period of the tick,
  /// the shortest of equally good delays. Returns 0 if no tick is known or there are no flashes.
  Duration delay(MonoTime earliest, const PulseSchedule& schedule) const noexcept;

 private:
  static constexpr std::size_t kSteps = 128;  ///< of the tick's period
  std::size_t step_of(Duration after_tick) const noexcept;

  Tick tick_;
  std::array<std::int64_t, kSteps> cost_{};  ///< of a flash so many steps after a tick's begin
};

}  // namespace strobe::firmware
