// Lateness samples with the span of time in which a freeze of the machine would explain them.
#pragma once

#include <cstddef>
#include <vector>

#include "common/units/time.hpp"
#include "tests/benchmarks/timing/freeze_detector.hpp"

namespace strobe::benchmarks::timing {

struct Sample {
  MonoTime from;  ///< a freeze that touches [from, to] ...
  MonoTime to;    ///< ... may have caused this lateness
  double lateness_us = 0.0;
  int cpu = -1;  ///< where it ran; -1: not known, a freeze of any core may have
};

/// Due at one instant, done at the other.
Sample sample_of(MonoTime due, MonoTime done, int cpu);

struct Percentiles {
  std::size_t count = 0;
  double p50_us = 0.0, p99_us = 0.0, p999_us = 0.0, max_us = 0.0;
};

/// Nearest-rank percentiles; zeros where there are no samples.
Percentiles percentiles(std::vector<double> lateness_us);

std::vector<double> latenesses(const std::vector<Sample>& samples);
/// Of those that no freeze touches.
std::vector<double> outside(const std::vector<Sample>& samples, const std::vector<Freeze>& freezes);

void append(std::vector<Sample>& to, const std::vector<Sample>& from);

}  // namespace strobe::benchmarks::timing
