// Whether the kernel was running on a core while something on it was late, though the core did not freeze.
#pragma once

#include <string>
#include <vector>

#include "tests/benchmarks/timing/sample.hpp"

namespace strobe::benchmarks::timing {

struct KernelActivity {
  std::size_t late = 0;        ///< samples later than the limit, outside freezes, of a known core
  std::size_t interrupts = 0;  ///< taken by their core between due and done
  std::size_t in_kernel = 0;   ///< of these, how many interrupted the kernel
};

/// `interrupts`: of each core. All counts are 0 without them, or if no sample's core is known.
KernelActivity kernel_activity(const std::vector<Sample>& samples, const std::vector<Freeze>& freezes,
                               const std::vector<std::vector<CoreInterrupt>>& interrupts, Duration limit);

/// "31 later than 100 us outside freezes, meanwhile their core was in the kernel at 40 of 41 looks"
std::string in_words(const KernelActivity& held, Duration limit);

}  // namespace strobe::benchmarks::timing
