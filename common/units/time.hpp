// Instants and spans of time in nanoseconds. Each clock has a type of its own, so that instants of two clocks
// cannot be compared or subtracted. Messages hold them as int64 `_ns` fields; everywhere else they have these
// types. Plain values: constexpr, thread-safe, real-time safe. Arithmetic does not check for overflow (±292
// years).
#pragma once

#include <chrono>
#include <cmath>
#include <cstdint>

namespace strobe {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;

using Duration = std::chrono::nanoseconds;

/// CLOCK_MONOTONIC of the machine that strobed runs on, the clock of the kernel's edge stamps. It has no
/// now(): only a clock port reads it (firmware/ports/clock.hpp), so that programs also run on a virtual
/// clock.
struct MonotonicClock {
  using duration = Duration;
  using rep = duration::rep;
  using period = duration::period;
  using time_point = std::chrono::time_point<MonotonicClock>;
  static constexpr bool is_steady = true;
};

/// Comparable only within one boot of that machine.
using MonoTime = std::chrono::time_point<MonotonicClock, Duration>;

/// CLOCK_MONOTONIC of the host's machine, which may be another one.
struct HostClock {};
using HostTime = std::chrono::time_point<HostClock, Duration>;

/// UTC by a machine's CLOCK_REALTIME, which may be set at any time: for file names and records.
using WallTime = std::chrono::sys_time<Duration>;

/// An instant that was not observed: NO_TIME of the messages, INT64_MIN.
inline constexpr MonoTime kNoTime = MonoTime::min();
constexpr bool known(MonoTime t) { return t != kNoTime; }

/// From and to a message's `_ns` field.
template <typename Time = MonoTime>
constexpr Time from_ns(std::int64_t ns) {
  return Time{Duration{ns}};
}
template <typename Clock>
constexpr std::int64_t to_ns(std::chrono::time_point<Clock, Duration> t) {
  return t.time_since_epoch().count();
}

constexpr double to_seconds(Duration d) { return static_cast<double>(d.count()) * 1e-9; }
constexpr double to_microseconds(Duration d) { return static_cast<double>(d.count()) * 1e-3; }
/// Rounded to the nearest nanosecond. Valid: |s| <= 9.2e9.
inline Duration from_seconds(double s) { return Duration{std::llround(s * 1e9)}; }

}  // namespace strobe
