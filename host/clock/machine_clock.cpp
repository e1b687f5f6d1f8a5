#include "host/clock/machine_clock.hpp"

#include <ctime>

namespace strobe::host {
namespace {

std::int64_t now_ns(clockid_t clock) {
  timespec time{};
  clock_gettime(clock, &time);
  return static_cast<std::int64_t>(time.tv_sec) * 1'000'000'000 + time.tv_nsec;
}

}  // namespace

std::int64_t steady_now_ns() { return now_ns(CLOCK_MONOTONIC); }

ClockReading MachineClock::read() {
  return {now_ns(CLOCK_MONOTONIC), now_ns(CLOCK_REALTIME), now_ns(CLOCK_BOOTTIME)};
}

}  // namespace strobe::host
