// Chooses a shot's start within one period of the kernel's timer tick so that its flashes fall between ticks.
//
// If the periods of train and tick have a large common divisor (3 ms and 4 ms: 1 ms), it depends on the start
// whether one flash in a few meets the tick, or none. Other trains lose nothing. The ball times a gated
// burst: it is not moved.
#pragma once

#include <array>

#include "firmware/core/pulse_schedule.hpp"
#include "firmware/core/tick.hpp"

namespace strobe::firmware {

/// Real-time safe (some 20 us a call), one thread's.
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
