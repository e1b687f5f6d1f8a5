// Cost of a call: the least of several repetitions, since whatever else a machine does only adds. Calls are
// timed in stretches of about a tenth of a millisecond, the least of each kept, so that one is rarely
// interrupted. One thread's.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <limits>

namespace strobe::studies::trade {

/// Keeps the compiler from leaving out what made `value`.
template <typename Value>
inline void keep(const Value& value) {
  asm volatile("" : : "r"(&value) : "memory");
}

/// Microseconds that `times` rounds of call(first)...call(last - 1) take.
template <typename Call>
double stretch_us(std::size_t first, std::size_t last, int times, const Call& call) {
  const auto start = std::chrono::steady_clock::now();
  for (int t = 0; t < times; ++t)
    for (std::size_t i = first; i < last; ++i) call(i);
  return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count();
}

/// Microseconds a call, the mean over call(0)...call(calls - 1), of slow ones over the first few.
template <typename Call>
double least_cost_us(int repetitions, std::size_t calls, const Call& call) {
  constexpr double kStretch_us = 100.0;
  constexpr double kSlow_us = 1000.0;
  constexpr std::size_t kFew = 20;
  const std::size_t few = std::min(calls, kFew);
  const double few_us = std::min(stretch_us(0, few, 1, call), stretch_us(0, few, 1, call));
  const double each_us = std::max(few_us, 1e-3) / static_cast<double>(few);
  if (each_us > kSlow_us) calls = few;
  const std::size_t length =
      std::clamp<std::size_t>(static_cast<std::size_t>(kStretch_us / each_us), 1, calls);
  const int times = std::max(1, static_cast<int>(kStretch_us / (each_us * static_cast<double>(length))));
  double sum_us = 0.0;
  for (std::size_t first = 0; first < calls; first += length) {
    const std::size_t last = std::min(first + length, calls);
    double least_us = std::numeric_limits<double>::infinity();
    for (int i = 0; i < repetitions; ++i) least_us = std::min(least_us, stretch_us(first, last, times, call));
    sum_us += least_us / times;
  }
  return sum_us / static_cast<double>(calls);
}

}  // namespace strobe::studies::trade
