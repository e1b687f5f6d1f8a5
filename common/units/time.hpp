// Instants and spans of time: nanoseconds of CLOCK_MONOTONIC, the clock of the kernel's edge stamps.
// Messages hold them as int64 `_ns` fields; everywhere else they have these types. Plain values: constexpr,
// thread-safe, real-time safe. Arithmetic does not check for overflow (±292 years).
#pragma once

#include <chrono>
#include <cmath>
#include <cstdint>

namespace strobe {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;

using Duration = std::chrono::nanoseconds;

/// CLOCK_MONOTONIC. It has no now(): only a clock port reads it (firmware/ports/clock.hpp), so that programs
/// also run on a virtual clock.
struct MonotonicClock {
  using duration = Duration;
  using rep = duration::rep;
  using period = duration::period;
  using time_point = std::chrono::time_point<MonotonicClock>;
  static constexpr bool is_steady = true;
};

using MonoTime = std::chrono::time_point<MonotonicClock, Duration>;

/// An instant that was not observed: NO_TIME of the messages, INT64_MIN.
inline constexpr MonoTime kNoTime = MonoTime::min();
constexpr bool known(MonoTime t) { return t != kNoTime; }

/// From and to a message's `_ns` field.
constexpr MonoTime from_ns(std::int64_t ns) { return MonoTime{Duration{ns}}; }
constexpr std::int64_t to_ns(MonoTime t) { return t.time_since_epoch().count(); }

constexpr double to_seconds(Duration d) { return static_cast<double>(d.count()) * 1e-9; }
/// Rounded to the nearest nanosecond. Valid: |s| <= 9.2e9.
inline Duration from_seconds(double s) { return Duration{std::llround(s * 1e9)}; }

}  // namespace strobe
