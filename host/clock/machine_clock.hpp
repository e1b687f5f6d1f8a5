// This machine's clocks. Reads them; thread-safe.
#pragma once

#include "host/clock/clock_reading.hpp"

namespace strobe::host {

class MachineClock final : public Clock {
 public:
  /// All three, one right after the other.
  HostReading read() override;
};

/// For progress and time limits.
HostTime steady_now();

}  // namespace strobe::host
