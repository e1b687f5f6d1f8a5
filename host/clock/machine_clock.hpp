// This machine's clocks. Reads them; thread-safe.
#pragma once

#include "host/clock/clock_reading.hpp"

namespace strobe::host {

class MachineClock final : public Clock {
 public:
  /// All three, one right after the other.
  ClockReading read() override;
};

/// CLOCK_MONOTONIC, for progress and time limits.
std::int64_t steady_now_ns();

}  // namespace strobe::host
