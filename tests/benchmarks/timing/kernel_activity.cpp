#include "tests/benchmarks/timing/kernel_activity.hpp"

#include <algorithm>

namespace strobe::benchmarks::timing {

KernelActivity kernel_activity(const std::vector<Sample>& samples, const std::vector<Freeze>& freezes,
                               const std::vector<std::vector<CoreInterrupt>>& interrupts, Duration limit) {
  KernelActivity held;
  for (const Sample& sample : samples) {
    if (sample.cpu < 0 || sample.to - sample.from <= limit) continue;
    if (static_cast<std::size_t>(sample.cpu) >= interrupts.size()) continue;
    if (within_freeze(freezes, sample.from, sample.to, sample.cpu)) continue;
    ++held.late;
    const auto& of_core = interrupts[static_cast<std::size_t>(sample.cpu)];
    const auto before = [](const CoreInterrupt& interrupt, MonoTime t) { return interrupt.at < t; };
    auto each = std::lower_bound(of_core.begin(), of_core.end(), sample.from, before);
    for (; each != of_core.end() && each->at < sample.to; ++each) {
      ++held.interrupts;
      if (each->in_kernel) ++held.in_kernel;
    }
  }
  return held;
}

std::string in_words(const KernelActivity& held, Duration limit) {
  return std::to_string(held.late) + " later than " + std::to_string(limit / microseconds(1)) +
         " us outside freezes, meanwhile their core was in the kernel at " + std::to_string(held.in_kernel) +
         " of " + std::to_string(held.interrupts) + " looks";
}

}  // namespace strobe::benchmarks::timing
