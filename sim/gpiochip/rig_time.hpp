// The time that all programs of a simulated rig share: as true to each of them as the machine's time is where
// nothing else runs, and independent of what the machine does beside them.
//
// Time stands still while any thread of theirs runs, but for one that asked for real-time priority and waits
// with ppoll(2): this one, strobed's loop, advances it by a fixed charge for each look at the clock, whatever
// the machine takes in between. What all others do takes no time. Once all of them sleep, the keeper
// (time_keeper.hpp) lets time go on to the earliest instant that any of them waits for and wakes that one
// alone: ties go to the lowest thread id. So whatever a program does is done at the instant that it waited
// for, in the same order each time, however busy the machine.
//
// The loop runs on alone until the next instant that somebody else waits for, where it is held until all
// sleep again. The rig answers each change of a line before the loop goes on. Words that the loop leaves for
// others (an eventfd) reach them when it sleeps or is held.
//
// Pace::wall lets time go on no faster than the machine's CLOCK_MONOTONIC, and catches up with it: for
// programs beside the rig that live in the machine's time. Pace::fast waits for nobody.
//
// What waits for an instant are the calls in preload/time.cpp; other waits with a limit (epoll, timerfd,
// futexes of one's own) end in the machine's time. What cannot be shown is in ../README.md.
//
// Thread-safe; of a State in shared memory. Nothing here allocates.
#pragma once

#include <poll.h>
#include <signal.h>

#include <cstdint>

#include "sim/gpiochip/state.hpp"

namespace strobe::sim::gpio {

inline constexpr std::int64_t kNever = INT64_MAX;

/// CLOCK_MONOTONIC of the rig, or the machine's if no time is kept. For the loop a step. [ns]
std::int64_t now_ns(State& state);
/// CLOCK_REALTIME and CLOCK_BOOTTIME of the rig, or the machine's. [ns]
std::int64_t realtime_ns(State& state);
std::int64_t boottime_ns(State& state);

inline bool is_kept(const State& state) { return state.time.pace.load() != Pace::machine; }

/// The process takes part in the rig's time: all its threads must sleep before time goes on.
void join_time(State& state, std::int32_t pid);

/// By it waits in ppoll() end (WakeBy::signal): one that no program waits for, and harmless by default.
inline constexpr int kWaitSignal = SIGURG;
/// Before the process starts threads: keeps that signal back, from this thread and those it starts.
void prepare_waits();

/// As ppoll(2), in rig time. `timeout_ns` below 0: no limit.
int wait_for(State& state, struct pollfd* polled, nfds_t count, std::int64_t timeout_ns,
             const sigset_t* signals = nullptr);

/// A wait that ends by itself: `slice()` waits for a millisecond of the machine's at most and tells whether
/// it is to end. False: `until_ns` has come.
template <typename Slice>
bool wait_in_slices(State& state, std::int64_t until_ns, Slice&& slice);

/// Until all others sleep: for one that another thread has started or woken.
void wait_for_turn(State& state);

/// The calling thread asked for a real-time policy, or for another one.
void note_real_time(bool real_time);
/// If it did, it is the loop from now on: its looks at the clock are steps, and the rig answers to it.
void become_loop(State& state);
bool is_loop();
/// The loop's write to an eventfd, put off until it sleeps. False: the caller is no loop, or there is no
/// room.
bool put_off_write(int fd, std::uint64_t value);

bool is_terminal(const State& state, int fd);
/// A write to the rig's terminal, that time waits for until the rig has taken it. By a FIFO: the kernel hands
/// over what is written to a terminal by a worker, which others hold up; a serial port's driver sends at
/// once. As write(2), but with -errno.
long write_to_terminal(State& state, const char* folder, const void* data, std::size_t size);

/// The rig's thread, once it has seen the ring's changes up to there: sleeps until `until_ns`, or a change.
/// `wake`: State::wake before it looked for changes.
void sleep_as_rig(State& state, std::uint64_t ring_position, std::uint32_t wake, std::int64_t until_ns);

/// Before the calling thread unmaps it.
void leave(State& state);

// How wait_in_slices() is made.
void begin_wait(State& state, std::int64_t until_ns, WakeBy wake_by);
void end_wait();

template <typename Slice>
bool wait_in_slices(State& state, std::int64_t until_ns, Slice&& slice) {
  begin_wait(state, until_ns, WakeBy::itself);
  bool ended = false;
  while (!ended && now_ns(state) < until_ns) ended = slice();
  end_wait();
  return ended;
}

}  // namespace strobe::sim::gpio
