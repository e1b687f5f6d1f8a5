// A background thread that does one job after the other, from a queue of limited length. Thread-safe.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>

namespace strobe::web {

class Worker {
 public:
  explicit Worker(std::size_t max_waiting);
  ~Worker() { end(); }
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  /// False if the queue is full, or the end has come: the job is not done.
  bool add(std::function<void()> job);
  /// Jobs that wait are dropped; the one under way is waited for, a fifth of a second at most. False if it still goes on:
  /// then what it uses must be left as it is until the process ends.
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

/// Whether a job of some worker goes on although its worker has ended: the process should end without taking down what
/// the job uses (_exit).
bool work_left_behind();

}  // namespace strobe::web
