// One instant and one span, both in nanoseconds of CLOCK_MONOTONIC: the clock of the kernel's edge stamps.
// Plain values: constexpr, thread-safe, real-time safe. Only a clock port reads the clock.
#pragma once

#include <compare>
#include <cstdint>
#include <limits>

namespace strobe {

/// A span of time. Range: ±292 years; arithmetic does not check for overflow.
struct Duration {
  std::int64_t ns = 0;

  constexpr auto operator<=>(const Duration&) const = default;
  constexpr double seconds() const { return static_cast<double>(ns) * 1e-9; }
};

constexpr Duration nanoseconds(std::int64_t n) { return {n}; }
constexpr Duration microseconds(std::int64_t n) { return {n * 1'000}; }
constexpr Duration milliseconds(std::int64_t n) { return {n * 1'000'000}; }

constexpr Duration operator+(Duration a, Duration b) { return {a.ns + b.ns}; }
constexpr Duration operator-(Duration a, Duration b) { return {a.ns - b.ns}; }
constexpr Duration operator-(Duration a) { return {-a.ns}; }
constexpr Duration operator*(Duration a, std::int64_t n) { return {a.ns * n}; }

/// An instant of CLOCK_MONOTONIC. `never()` marks an instant that was not observed; it is the value that
/// messages use for "none" (INT64_MIN).
struct MonoTime {
  std::int64_t ns = 0;

  constexpr auto operator<=>(const MonoTime&) const = default;
  static constexpr MonoTime never() { return {std::numeric_limits<std::int64_t>::min()}; }
  constexpr bool known() const { return ns != std::numeric_limits<std::int64_t>::min(); }
};

constexpr MonoTime operator+(MonoTime t, Duration d) { return {t.ns + d.ns}; }
constexpr MonoTime operator-(MonoTime t, Duration d) { return {t.ns - d.ns}; }
constexpr Duration operator-(MonoTime a, MonoTime b) { return {a.ns - b.ns}; }

}  // namespace strobe
