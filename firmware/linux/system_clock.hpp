// The clock port on CLOCK_MONOTONIC. Real-time safe (vDSO, no system call on the usual clock sources).
#pragma once

#include <ctime>

#include "firmware/ports/clock.hpp"

namespace strobe::firmware {

class SystemClock final : public Clock {
 public:
  MonoTime now() noexcept override {
    timespec t{};
    clock_gettime(CLOCK_MONOTONIC, &t);
    return from_ns(t.tv_sec * 1'000'000'000 + t.tv_nsec);
  }
  MonoTime spin_until(MonoTime instant) noexcept override {
    MonoTime t = now();
    while (t < instant) t = now();
    return t;
  }
};

}  // namespace strobe::firmware
