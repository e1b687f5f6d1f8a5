// How often a board's own firmware took a CPU from the kernel: system management interrupts (SMI), as x86
// processors count them (MSR_SMI_COUNT), through the kernel's performance events. Set-up only.
#pragma once

#include <set>
#include <vector>

#include "firmware/linux/perf_event.hpp"
#include "firmware/linux/system_files.hpp"

namespace strobe::firmware {

class SmiCounter {
 public:
  SmiCounter(const std::set<int>& cpus, const SystemFiles& files);
  /// Of all the CPUs together, since this was made; -1: kernel or processor does not count them, or this
  /// user may not know.
  long count() const;

 private:
  std::vector<PerfEvent> events_;
};

}  // namespace strobe::firmware
