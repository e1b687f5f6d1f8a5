// Lateness samples with the span of time in which a freeze of the machine would explain them.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "common/units/time.hpp"

namespace strobe::bench {

struct Sample {
  MonoTime from;  ///< a freeze that touches [from, to] ...
  MonoTime to;    ///< ... may have caused this lateness
  double lateness_us = 0.0;
};

struct Percentiles {
  std::size_t count = 0;
  double p50_us = 0.0;
  double p99_us = 0.0;
  double p999_us = 0.0;
  double max_us = 0.0;
};

/// Nearest-rank percentiles; zeros where there are no samples.
Percentiles percentiles(std::vector<double> lateness_us);

/// Of every flash in a journal of strobed.
struct FlashSamples {
  std::vector<Sample> issue;  ///< issue_start - commanded: what cyclictest measures of a wake-up
  std::vector<Sample> done;   ///< issue_end - commanded: with the set-values call, here the simulated chip's
};

FlashSamples flashes_of_journal(const std::string& path);

/// Runs `cyclictest` (rt-tests) for so many seconds; its verbose output, one line a wake-up, is stamped on
/// arrival.
std::vector<Sample> run_cyclictest(int priority, Duration period, int seconds);

}  // namespace strobe::bench
