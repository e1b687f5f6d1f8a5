// A timer interrupt every millisecond on one core, time-stamped by the kernel within the interrupt itself
// (perf_event_open(2), the software event cpu-clock; CLOCK_MONOTONIC).
//
// It comes at whole milliseconds, like the kernel's tick, whatever runs on the core: user code, a real-time
// thread, or the kernel in a section without preemption. Only a core that stands still, or a rare section
// with interrupts disabled, makes one late. Each costs some 2 us. Single-threaded.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/units/time.hpp"

namespace strobe::benchmarks::timing {

struct CoreInterrupt {
  MonoTime at;
  bool in_kernel = false;  ///< what it interrupted
};

class CoreInterrupts {
 public:
  /// Returns nullopt if the kernel refuses (it needs root, CAP_PERFMON or perf_event_paranoid below 1), or never
  /// starts them within 30 us of a whole millisecond. The calling thread moves to the core meanwhile, with
  /// real-time priority 1.
  static std::optional<CoreInterrupts> open(int cpu);
  CoreInterrupts(CoreInterrupts&& other) noexcept;
  CoreInterrupts& operator=(CoreInterrupts&&) = delete;
  ~CoreInterrupts();

  /// Appends the interrupts since the last call. Call it at least every 20 s: the kernel keeps no more.
  /// Throws std::runtime_error if some were lost.
  void take(std::vector<CoreInterrupt>& interrupts);

  static constexpr Duration kPeriod = milliseconds(1);

 private:
  CoreInterrupts(int fd, char* pages) : fd_(fd), pages_(pages) {}
  bool in_place();

  int fd_ = -1;
  char* pages_ = nullptr;
  std::uint64_t read_ = 0;
};

}  // namespace strobe::benchmarks::timing
