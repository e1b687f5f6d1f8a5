// cyclictest of Debian's rt-tests, as the reference that the loop is compared with.
#pragma once

#include <vector>

#include "tests/benchmarks/timing/loop_run.hpp"
#include "tests/benchmarks/timing/sample.hpp"

namespace strobe::benchmarks::timing {

/// Runs it with the same priority, period and CPU. Its wake-ups are put half a millisecond off the kernel's
/// tick and the freeze detector, as the loop puts its flashes: left to chance it would do worse. std::runtime_error
/// if it cannot be run.
std::vector<Sample> run_cyclictest(const LoopSettings& like);

/// Its wake-ups, from the lateness of each in their order and when the first was heard of: it prints no
/// instants, but began at a whole second of CLOCK_MONOTONIC and half a millisecond, waits for every period
/// from there, and leaves out those that have passed before it is done with the last. So that a freeze is
/// looked for in the same span as for a flash: from the instant it was due.
std::vector<Sample> wake_ups_of(const std::vector<Duration>& lateness, MonoTime first_heard, Duration period,
                                int cpu);

}  // namespace strobe::benchmarks::timing
