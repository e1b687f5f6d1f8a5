// The time that the programs of a simulated rig share, as true to a real-time loop as the machine's time is where
// nothing else runs, and independent of what the machine does beside it.
//
// Rig time is the machine's CLOCK_MONOTONIC, but it waits for two: the loop of the program under test, which is to be
// woken, runs or has an edge to see, and the rig, which has something due or a change to look at. While the loop runs,
// time advances with its steps from one look at the clock to the next, each counted as kLongestStep at most: whoever
// took the core from it in between took no rig time. When both sleep, time follows the machine's again, past one wake-up
// after the other, so that other programs' clocks stay with it. Everybody else may be late, as on any busy machine.
//
// A loop that no longer looks at the clock (it hangs, is stopped or dead) is waited for as long as it is only kept from
// running; then time goes on without it (watch_loop).
//
// Thread-safe; of a State in shared memory. Nothing allocates; only the loop waits, and only for the rig.
#pragma once

#include <cstdint>

#include "sim/gpiochip/state.hpp"

namespace strobe::sim::gpio {

inline constexpr std::int64_t kNever = INT64_MAX;
/// Between two looks at the clock the loop makes one system call or some arithmetic: 0.1 to 3 us on an idle machine.
inline constexpr std::int64_t kLongestStep = 5'000;

/// CLOCK_MONOTONIC of the rig, or the machine's if no rig time is kept. For the loop a step. [ns]
std::int64_t now_ns(State& state);
/// How far the rig's clocks are behind the machine's. [ns]
std::int64_t lag_ns(State& state);

/// The rig's side. From the first on time is kept; until the other it waits.
void keep_time(State& state, std::uint64_t ring_position);
void stop_keeping_time(State& state);
/// The rig has done what was due and seen the ring's changes up to there; `due_ns` is what comes next.
void rig_turned(State& state, std::uint64_t ring_position, std::int64_t due_ns);
/// Before an edge goes to the program: a sleeping loop will be woken at it.
void hold_for_edge(State& state, std::int64_t stamp_ns);

/// Looks each 10 ms of the machine's whether the loop that time waits for could go on. Of one thread.
class LoopWatch {
 public:
  void look(State& state);

 private:
  std::int64_t looked_ns_ = 0;
  std::int64_t at_ns_ = 0;
  std::uint64_t ran_ns_ = 0;
  int stuck_ = 0;
};

/// The loop's side: the calling thread is the loop from now on.
void become_loop(State& state);
bool is_loop();
/// The loop sleeps for `duration_ns`, or for ever if that is below 0; `poll(timeout_ns)` is native and waits at most so
/// long, 0 not at all. Its answer, once it is not 0, or when the duration is over. Wake-ups are late by what a drawn
/// 10 to 70 us stands for: as seen on an idle machine.
template <typename Poll>
int sleep_loop(State& state, std::int64_t duration_ns, Poll&& poll);

// How sleep_loop() is made.
std::int64_t begin_sleep(State& state, std::int64_t duration_ns);
/// For how long to poll natively; 0: the sleep is over. [ns]
std::int64_t left_to_sleep(State& state, std::int64_t wake_ns);
void end_sleep(State& state, bool by_event);

template <typename Poll>
int sleep_loop(State& state, std::int64_t duration_ns, Poll&& poll) {
  const std::int64_t wake_ns = begin_sleep(state, duration_ns);
  int ready = 0;
  for (std::int64_t left = 1; ready == 0 && left > 0;) {
    left = left_to_sleep(state, wake_ns);
    ready = poll(left);
    // An edge that this loop does not poll for: nobody is woken by it.
    if (ready == 0) state.time.edge_ns.store(kNever);
  }
  end_sleep(state, ready != 0);
  return ready;
}

}  // namespace strobe::sim::gpio
