// Tells of the death of another process's thread, of whatever cause, before the kernel takes apart that process's
// memory (which may take milliseconds) and long before it lets go of its descriptors. In memory that both processes
// share. A robust mutex: a waiter is woken as one of the first things of the holder's end.
#pragma once

#include <pthread.h>

#include <atomic>

namespace strobe::firmware {

class Lifeline {
 public:
  Lifeline();
  Lifeline(const Lifeline&) = delete;
  Lifeline& operator=(const Lifeline&) = delete;

  /// The calling thread is watched from now on: once, before anybody waits.
  void hold() noexcept { pthread_mutex_lock(&mutex_); }
  /// By the holder, which ends in good order.
  void let_go() noexcept { pthread_mutex_unlock(&mutex_); }
  /// Waits for the holder's end. Returns true if it died, false if it let go. For one waiter, once.
  bool wait_for_death() noexcept;
  /// Whether it has, without waiting: for another thread of the waiter's process. Real-time safe.
  bool holder_died() noexcept;

 private:
  void take_over(int lock_result) noexcept;

  pthread_mutex_t mutex_;
  std::atomic<bool> died_{false};
};

}  // namespace strobe::firmware
