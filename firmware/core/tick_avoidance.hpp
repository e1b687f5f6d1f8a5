// Picks a shot's start within one period of the kernel's tick, so that its flashes fall between ticks.
//
// A train whose period and the tick's have a large common divisor (3 ms and 4 ms: 1 ms) either meets the tick
// with one flash in a few, or with none, as its start has it. Other trains lose nothing. A burst that a gate
// starts has its instants from the ball: nothing can be chosen there.
#pragma once

#include <array>

#include "firmware/core/shot_plan.hpp"
#include "firmware/core/tick.hpp"

namespace strobe::firmware {

/// Real-time safe (some 20 us a call), one thread's.
class TickAvoidance {
 public:
  explicit TickAvoidance(const Tick& tick) noexcept;

  /// How much later than `earliest` the plan's first instant should be: 0 to one period of the tick, the
  /// least where several are as good; 0 if no tick is known or the plan has no flash.
  Duration delay(MonoTime earliest, const ShotPlan& plan) const noexcept;

 private:
  static constexpr std::size_t kSteps = 128;  ///< of the tick's period
  std::size_t step_of(Duration after_tick) const noexcept;

  Tick tick_;
  std::array<std::int64_t, kSteps> cost_{};  ///< of a flash so many steps after a tick's begin
};

}  // namespace strobe::firmware
