// What a machine's own clocks say of each other: whether its wall clock was set, whether it slept.
// CLOCK_MONOTONIC is immune to the first and stands still in the second. No I/O; a plain value.
#pragma once

#include <cstdint>
#include <optional>

namespace strobe::host {

/// Read together, in nanoseconds.
struct ClockReading {
  std::int64_t mono_ns = 0;
  std::int64_t wall_ns = 0;
  std::int64_t boot_time_ns = 0;  ///< as mono_ns, but goes on while the machine is suspended
};

/// The port that reads the machine's clocks.
class Clock {
 public:
  virtual ~Clock() = default;
  virtual ClockReading read() = 0;
};

class ClockStepDetector {
 public:
  struct Change {
    std::int64_t stepped_ns = 0;    ///< the wall clock was set by this much; 0: it was not
    std::int64_t suspended_ns = 0;  ///< the machine was suspended for this long; 0: it was not
  };

  /// What has changed since the reading before; nothing: neither. Less than 50 ms, or half a thousandth of
  /// the time in between, passes for slewing and for clocks that were not read quite together.
  std::optional<Change> on_reading(const ClockReading& now);
  void forget() { last_.reset(); }

 private:
  std::optional<ClockReading> last_;
};

}  // namespace strobe::host
