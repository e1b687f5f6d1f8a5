#include "host/clock/machine_clock.hpp"

#include <ctime>

namespace strobe::host {
namespace {

Duration elapsed(clockid_t clock) {
  timespec time{};
  clock_gettime(clock, &time);
  return std::chrono::seconds{time.tv_sec} + Duration{time.tv_nsec};
}

}  // namespace

HostTime steady_now() { return HostTime{elapsed(CLOCK_MONOTONIC)}; }

HostReading MachineClock::read() {
  return {steady_now(), WallTime{elapsed(CLOCK_REALTIME)}, elapsed(CLOCK_BOOTTIME)};
}

}  // namespace strobe::host
