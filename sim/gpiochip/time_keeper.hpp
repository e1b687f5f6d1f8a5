// Keeps the time of a rig's programs (rig_time.hpp): once all of them sleep, it lets time go on to the next instant that
// any thread waits for, and wakes that one. A thread of its own. Start and stop from one thread.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <thread>

#include "sim/gpiochip/state.hpp"

namespace strobe::sim::gpio {

class TimeKeeper {
 public:
  /// For a run that is to repeat to the byte.
  struct Repeatable {
    std::int64_t start_s = 0;  ///< of CLOCK_MONOTONIC; CLOCK_REALTIME starts as many seconds after 2000-01-01
    std::uint64_t seed = 1;    ///< of what the programs draw (preload/random.cpp)
  };
  /// From now on time is kept, at first the machine's; it stands still until another program joins (join_time). `state` must outlive the keeper. The calling process takes part.
  TimeKeeper(State& state, Pace pace, const std::optional<Repeatable>& repeatable = std::nullopt);
  /// The programs' clocks go on at the machine's pace, from where they are.
  ~TimeKeeper();
  TimeKeeper(const TimeKeeper&) = delete;
  TimeKeeper& operator=(const TimeKeeper&) = delete;

 private:
  void run();

  State& state_;
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace strobe::sim::gpio
