// State that worker and guardian share: a page of shared memory, and an eventfd that wakes the guardian.
// Thread-safe, process-safe, real-time safe.
#pragma once

#include <unistd.h>

#include <atomic>
#include <cstdint>

namespace strobe::firmware {

struct SharedStatus {
  std::atomic<bool> lines_taken{false};   ///< the worker owns the output lines
  std::atomic<bool> outputs_safe{false};  ///< it has made them inactive and is stopping
  /// It can no longer drive them and has released them: the guardian takes them over now.
  std::atomic<bool> lines_released{false};
  std::atomic<bool> ready{false};                  ///< its first status is published
  std::atomic<std::int64_t> boot_id{0};            ///< the worker's; 0: not yet drawn
  std::atomic<std::int64_t> loop_heartbeat_ns{0};  ///< when the loop last ran; 0: not yet
  std::atomic<int> loop_cpu{-1};                   ///< the CPU it ran on
  std::atomic<std::int64_t> publisher_heartbeat_ns{0};
  std::atomic<std::int64_t> guardian_heartbeat_ns{0};
  int event_fd = -1;  ///< an eventfd; set before the fork

  void notify() const noexcept {
    const std::uint64_t one = 1;
    // Cannot fail before 2^64 - 2 notifications are unread.
    [[maybe_unused]] const ssize_t written = write(event_fd, &one, sizeof one);
  }
};

}  // namespace strobe::firmware
