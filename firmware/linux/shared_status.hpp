// State that worker and guardian share: a page of shared memory, and an eventfd that wakes the guardian.
// Thread-safe, process-safe, real-time safe (but for waiting).
#pragma once

#include <unistd.h>

#include <atomic>
#include <cstdint>

#include "firmware/linux/lifeline.hpp"

namespace strobe::firmware {

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
  int event_fd = -1;       ///< an eventfd; set before the fork
  pid_t guardian_pid = 0;  ///< set before the fork

  void notify() const noexcept {
    const std::uint64_t one = 1;
    // Cannot fail before 2^64 - 2 notifications are unread.
    [[maybe_unused]] const ssize_t written = write(event_fd, &one, sizeof one);
  }
};

}  // namespace strobe::firmware
