// Cost of a call: the least of several repetitions, since whatever else a machine does only adds. One
// thread's.
#pragma once

#include <algorithm>
#include <chrono>
#include <limits>

namespace strobe::bench::trade {

/// Keeps the compiler from leaving out what made `value`.
template <typename Value>
inline void keep(const Value& value) {
  asm volatile("" : : "r"(&value) : "memory");
}

/// Microseconds a call. pass() makes `calls` calls; passes follow each other until a repetition has lasted
/// long enough for the clock (20 us and more).
template <typename Pass>
double least_cost_us(int repetitions, std::size_t calls, Pass&& pass) {
  using Clock = std::chrono::steady_clock;
  constexpr double kShortest_us = 20.0;
  double least_us = std::numeric_limits<double>::infinity();
  int passes = 1;
  for (int i = 0; i < repetitions;) {
    const auto start = Clock::now();
    for (int p = 0; p < passes; ++p) pass();
    const double took_us = std::chrono::duration<double, std::micro>(Clock::now() - start).count();
    if (took_us < kShortest_us && passes < (1 << 20)) {
      passes *= 2;
      continue;
    }
    least_us = std::min(least_us, took_us / (static_cast<double>(calls) * passes));
    ++i;
  }
  return least_us;
}

}  // namespace strobe::bench::trade
