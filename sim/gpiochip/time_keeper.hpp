// Keeps the time of a rig's programs (rig_time.hpp): once all of them sleep, it lets time go on to the next
// instant that any thread waits for, and wakes that one. A thread of its own. Start and stop from one thread.
#pragma once

#include <sys/types.h>

#include <atomic>
#include <cstdint>
#include <map>
#include <optional>
#include <thread>
#include <vector>

#include "sim/gpiochip/state.hpp"

namespace strobe::sim::gpio {

class TimeKeeper {
 public:
  /// For a run that is to repeat to the byte.
  struct Repeatable {
    std::int64_t start_s = 0;  ///< of CLOCK_MONOTONIC; CLOCK_REALTIME starts as many seconds after 2000-01-01
    std::uint64_t seed = 1;    ///< of what the programs draw (preload/random.cpp)
  };
  /// From now on time is kept, at first the machine's; it stands still until another program joins
  /// (join_time). `state` must outlive the keeper. The calling process takes part.
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

/// Whether all threads of some programs sleep, as /proc tells it: a snapshot in which none of them ran. One
/// thread.
class ThreadStates {
 public:
  /// `excepted`: a thread that does not count, the caller's own.
  explicit ThreadStates(pid_t excepted);

  /// What it reads of a program's threads is kept until a call without the program.
  void watch(const std::vector<pid_t>& programs);

  /// True if every thread slept, was stopped or dead throughout the call. A thread that waits for the disk
  /// does not sleep, nor does one that was woken and waits for a core; datagrams on their way through the
  /// kernel are waited for.
  bool all_asleep();

  /// Of a thread that all_asleep() found running: 0 if it found none.
  pid_t running() const { return running_; }
  /// That one, which has just been woken, is looked at first.
  void expect_running(pid_t tid) { running_ = tid; }
  /// Processor time that a thread has had. [ns]
  std::uint64_t consumed_ns(pid_t pid, pid_t tid);

 private:
  /// A file of /proc that is read again and again.
  class File {
   public:
    explicit File(const char* path);
    File(File&& other) noexcept;
    File& operator=(File&&) = delete;
    ~File();
    /// The text, or null if there is none any more. Valid until the next read of any.
    const char* read();

   private:
    int fd_ = -1;
  };
  struct Thread {
    pid_t tid;
    File stat;
    File schedstat;
    File wchan;
    std::uint64_t activity = 0;  ///< when it was looked at last
    std::uint64_t settled = 0;   ///< when it was last known to have left the processor to sleep
  };
  struct Program {
    std::uint64_t links = 0;  ///< of its folder of threads: 2 more than threads
    std::vector<Thread> threads;
    bool tells_wchan = false;  ///< it may be read
  };
  /// Changes if any thread has had the processor, be it for a moment.
  std::uint64_t activity();
  bool sleeps(Program& program, Thread& thread);
  bool all_sleep();
  bool has_settled(Program& program, Thread& thread) const;
  bool all_have_settled();
  void list_new_threads(pid_t pid, Program& program) const;
  bool network_is_quiet();

  pid_t excepted_;
  pid_t running_ = 0;
  std::map<pid_t, Program> programs_;
  File softnet_;
  std::uint64_t unsettled_ = 0;          ///< all activity, when one was last found not to have settled
  std::int64_t unsettled_since_ns_ = 0;  ///< of the machine's clock
};

}  // namespace strobe::sim::gpio
