// A machine's own clocks, and what they say of each other: whether its wall clock was set, whether it slept.
// CLOCK_MONOTONIC is immune to the first and stands still in the second. MachineClock reads this machine's
// and is thread-safe; the rest are plain values.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/units/time.hpp"

namespace strobe::host {

/// A machine's clocks, read together. Time: its CLOCK_MONOTONIC.
template <typename Time>
struct ClockReading {
  Time mono{};
  WallTime wall{};
  Duration since_boot{};  ///< as mono, but goes on while the machine is suspended
};
using HostReading = ClockReading<HostTime>;
using DeviceReading = ClockReading<MonoTime>;

/// The port that reads the machine's clocks.
class Clock {
 public:
  virtual ~Clock() = default;
  virtual HostReading read() = 0;
};

class MachineClock final : public Clock {
 public:
  /// All three, one right after the other.
  HostReading read() override;
};

/// For progress and time limits.
HostTime steady_now();

struct ClockChange {
  Duration stepped{};    ///< the wall clock was set by this much; 0: it was not
  Duration suspended{};  ///< the machine was suspended for this long; 0: it was not
};

/// For a person, a line each. whose: "this machine".
std::vector<std::string> describe(const ClockChange& change, const std::string& whose);

/// Time: MonoTime or HostTime.
template <typename Time>
class ClockStepDetector {
 public:
  /// What has changed since the reading before. Returns nullopt if neither. Less than 50 ms, or half a
  /// thousandth of the time in between, passes for slewing and for clocks that were not read quite together.
  std::optional<ClockChange> on_reading(const ClockReading<Time>& now);

 private:
  std::optional<ClockReading<Time>> last_;
};

}  // namespace strobe::host
