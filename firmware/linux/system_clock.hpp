// The clock port on CLOCK_MONOTONIC. Real-time safe (vDSO, no system call on the usual clock sources).
#pragma once

#include <algorithm>
#include <ctime>

#include "firmware/ports/clock.hpp"

namespace strobe::firmware {

/// Valid: not negative.
inline timespec to_timespec(Duration duration) {
  return {duration.count() / 1'000'000'000, duration.count() % 1'000'000'000};
}

class SystemClock final : public Clock {
 public:
  MonoTime now() noexcept override { return from_ns(read(CLOCK_MONOTONIC)); }
  MonoTime spin_until(MonoTime instant) noexcept override {
    MonoTime t = now();
    while (t < instant) t = now();
    return t;
  }
  /// CLOCK_BOOTTIME goes on in a suspended machine. It is read first: a preemption in between makes the sleep
  /// look shorter.
  Duration suspended() noexcept override {
    const std::int64_t boot_time = read(CLOCK_BOOTTIME);
    return Duration{boot_time - read(CLOCK_MONOTONIC)};
  }

 private:
  static std::int64_t read(clockid_t clock) noexcept {
    timespec t{};
    clock_gettime(clock, &t);
    return t.tv_sec * 1'000'000'000 + t.tv_nsec;
  }
};

/// From now to the instant, for ppoll(2); none if it has passed.
inline timespec time_left(MonoTime until) {
  return to_timespec(std::max(Duration{}, until - SystemClock().now()));
}

}  // namespace strobe::firmware
