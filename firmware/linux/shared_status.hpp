// What worker and guardian share: a page of memory, and an eventfd that wakes the guardian.
#pragma once

#include <pthread.h>
#include <unistd.h>

#include <atomic>
#include <cstdint>

namespace strobe::firmware {

/// Tells of the death of another process's thread, of whatever cause, before the kernel takes apart that
/// process's memory (which may take milliseconds) and long before it lets go of its descriptors. In memory
/// that both processes share. A robust mutex: a waiter is woken as one of the first things of the holder's
/// end. A second one for whoever looks without waiting: a woken waiter has the first for a moment, as the
/// living holder had it.
class Lifeline {
 public:
  Lifeline();
  Lifeline(const Lifeline&) = delete;
  Lifeline& operator=(const Lifeline&) = delete;

  /// The calling thread is watched from now on: once, before anybody waits.
  void hold() noexcept {
    pthread_mutex_lock(&waited_for_);
    pthread_mutex_lock(&looked_at_);
  }
  /// By the holder, which ends in good order.
  void let_go() noexcept {
    pthread_mutex_unlock(&looked_at_);
    pthread_mutex_unlock(&waited_for_);
  }
  /// Waits for the holder's end. Returns true if it died, false if it let go. For one waiter, once.
  bool wait_for_death() noexcept;
  /// Whether it has, without waiting: for one other thread of the waiter's process. Real-time safe.
  bool holder_died() noexcept;

 private:
  void take_over(pthread_mutex_t& mutex, int lock_result) noexcept;

  pthread_mutex_t waited_for_;
  pthread_mutex_t looked_at_;
  std::atomic<bool> died_{false};
};

/// Thread-safe, process-safe, real-time safe (but for waiting).
struct SharedStatus {
  Lifeline loop;                          ///< held by the worker's loop from before the worker is ready
  Lifeline guardian;                      ///< held by the guardian's main thread from before the fork
  std::atomic<bool> outputs_safe{false};  ///< the worker has made the outputs inactive and is stopping
  /// It can no longer drive them and has released them: the guardian makes them inactive now.
  std::atomic<bool> lines_released{false};
  /// Set before an output can become active; cleared when all are inactive and no shot is under way.
  std::atomic<bool> shot_under_way{false};
  std::atomic<bool> ready{false};                  ///< its first status is published
  std::atomic<std::int64_t> boot_id{0};            ///< the worker's; 0: not yet drawn
  std::atomic<std::int64_t> loop_heartbeat_ns{0};  ///< when the loop last ran; 0: not yet
  std::atomic<int> loop_cpu{-1};                   ///< the CPU it ran on
  std::atomic<std::int64_t> publisher_heartbeat_ns{0};
  std::atomic<std::int64_t> guardian_heartbeat_ns{0};
  std::atomic<std::int64_t> host_heard_ns{0};  ///< CLOCK_BOOTTIME of a host's newest command; 0: none yet
  int event_fd = -1;                           ///< an eventfd; set before the fork
  pid_t guardian_pid = 0;                      ///< set before the fork

  void notify() const noexcept {
    const std::uint64_t one = 1;
    // Cannot fail before 2^64 - 2 notifications are unread.
    [[maybe_unused]] const ssize_t written = write(event_fd, &one, sizeof one);
  }
};

}  // namespace strobe::firmware
