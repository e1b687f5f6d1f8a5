// cyclictest of Debian's rt-tests, as the yardstick.
#pragma once

#include <vector>

#include "tests/bench/timing/loop_run.hpp"
#include "tests/bench/timing/sample.hpp"

namespace strobe::bench::timing {

/// Runs it with the same priority, period and CPU; its verbose output, one line a wake-up, is stamped on
/// arrival. Its wake-ups are put half a millisecond off the kernel's tick and the witness, as the loop puts
/// its flashes: left to chance it would do worse. std::runtime_error if it cannot be run.
std::vector<Sample> run_cyclictest(const LoopSettings& like);

}  // namespace strobe::bench::timing
