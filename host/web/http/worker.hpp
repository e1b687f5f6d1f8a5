// Threads whose work can wait, since the host's own comes first; one does one job after the other, from a
// queue of limited length. Thread-safe.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>

namespace strobe::web {

/// A thread that the scheduler prefers others to (SCHED_BATCH, niceness 10) and that no signal interrupts.
/// name: at most 15 characters. What throws ends the thread's work, not the program.
std::thread background_thread(const char* name, std::function<void()> work);

class Worker {
 public:
  explicit Worker(std::size_t max_waiting);
  ~Worker() { end(); }
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  /// False if the queue is full, or the end has come: the job is not done.
  bool add(std::function<void()> job);
  /// Jobs that wait are dropped; the one under way is waited for, a fifth of a second at most. False if it
  /// still goes on: then what it uses must be left as it is until the process ends.
  bool end();

 private:
  struct State {
    std::mutex mutex;
    std::condition_variable changed;
    std::deque<std::function<void()>> jobs;
    bool busy = false, ending = false, ended = false;
  };
  static void run(State& state);

  std::size_t max_waiting_;
  std::shared_ptr<State> state_ = std::make_shared<State>();
};

/// Whether a job of some worker goes on although its worker has ended: the process should end without taking
/// down what the job uses (_exit).
bool work_left_behind();

}  // namespace strobe::web
