// Port: the one clock of the firmware, CLOCK_MONOTONIC.
#pragma once

#include "common/units/time.hpp"

namespace strobe::firmware {

/// Real-time safe: neither call blocks, allocates or sleeps.
class Clock {
 public:
  virtual ~Clock() = default;
  virtual MonoTime now() noexcept = 0;
  /// Spins until the instant; returns the first reading of the clock that is not before it.
  virtual MonoTime spin_until(MonoTime instant) noexcept = 0;
  /// How long the machine has been suspended since it was started, in which this clock stood still: never
  /// more than the truth. A clock that knows of no suspending machine says 0.
  virtual Duration suspended() noexcept { return {}; }
};

}  // namespace strobe::firmware
