// The benchmark's clock port. Thread-safe, real-time safe.
#pragma once

#include <time.h>

#include "common/units/time.hpp"

namespace strobe::benchmarks::timing {

inline MonoTime now() {
  timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);
  return from_ns(t.tv_sec * 1'000'000'000 + t.tv_nsec);
}

}  // namespace strobe::benchmarks::timing
