// Sees when the machine itself stands still: one thread a core wakes every millisecond and records where it
// was late.
//
// A virtual machine's host stops its cores for tens of milliseconds now and then, without telling.
// Percentiles of a real-time loop mean something only outside such freezes, so they are taken with and
// without them. The threads run below the priority of what is measured, and wake at whole milliseconds of the
// clock, where the kernel's tick is too: an interrupt of some 15 us is all they cost, and what is measured
// can keep out of its way. A spin of 200 us on their core stays below the threshold.
#pragma once

#include <atomic>
#include <thread>
#include <vector>

#include "common/units/time.hpp"

namespace strobe::bench::timing {

struct Freeze {
  MonoTime begin;  ///< it was still awake then: up to a period too early
  MonoTime end;
};

class Witness {
 public:
  explicit Witness(int priority);  ///< SCHED_FIFO priority; ordinary scheduling where that is refused
  ~Witness();
  Witness(const Witness&) = delete;
  Witness& operator=(const Witness&) = delete;

  /// Ends the watch and gives the freezes of all cores, sorted by their begin.
  std::vector<Freeze> stop();

  static constexpr Duration kPeriod = milliseconds(1);
  static constexpr Duration kThreshold = microseconds(600);  ///< a wake-up later than this is a freeze

 private:
  void watch(int cpu, int priority, std::vector<Freeze>& seen);

  std::atomic<bool> running_{true};
  std::vector<std::vector<Freeze>> seen_;
  std::vector<std::thread> threads_;
};

/// Whether the span [from, to] touches a freeze.
bool within_freeze(const std::vector<Freeze>& freezes, MonoTime from, MonoTime to);

}  // namespace strobe::bench::timing
