// Sees when the machine itself stands still: one thread a core wakes every 500 us and records where it was
// late.
//
// A virtual machine's host stops its cores for tens of milliseconds now and then, without telling.
// Percentiles of a real-time loop mean something only outside such freezes, so they are taken with and
// without them. The threads run below the priority of what is measured: they never delay it, and a spin of
// 200 us on their core stays below the threshold.
#pragma once

#include <atomic>
#include <thread>
#include <vector>

#include "common/units/time.hpp"

namespace strobe::bench {

struct Freeze {
  MonoTime begin;
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

  static constexpr Duration kPeriod = microseconds(500);
  static constexpr Duration kThreshold = milliseconds(1);  ///< a wake-up later than this is a freeze

 private:
  void watch(int cpu, int priority, std::vector<Freeze>& seen);

  std::atomic<bool> running_{true};
  std::vector<std::vector<Freeze>> seen_;
  std::vector<std::thread> threads_;
};

/// Whether the span [from, to] touches a freeze.
bool within_freeze(const std::vector<Freeze>& freezes, MonoTime from, MonoTime to);

}  // namespace strobe::bench
