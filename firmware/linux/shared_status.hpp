// What worker and guardian tell each other: shared memory, and a bell that wakes the guardian. Thread-safe,
// process-safe, real-time safe.
#pragma once

#include <unistd.h>

#include <atomic>
#include <cstdint>

namespace strobe::firmware {

struct SharedStatus {
  std::atomic<bool> lines_taken{false};   ///< the worker owns the output lines
  std::atomic<bool> outputs_safe{false};  ///< it has left them inactive and ends in good order
  /// It cannot drive them any more and has let go of them: the guardian is to take them now.
  std::atomic<bool> lines_released{false};
  std::atomic<bool> ready{false};                  ///< its first heartbeat is out
  std::atomic<std::int64_t> loop_heartbeat_ns{0};  ///< when its loop last came round; 0: not running yet
  std::atomic<int> loop_cpu{-1};                   ///< and where
  std::atomic<std::int64_t> publisher_heartbeat_ns{0};
  std::atomic<std::int64_t> guardian_heartbeat_ns{0};
  int event_fd = -1;  ///< an eventfd; set before the fork

  void notify() const noexcept {
    const std::uint64_t one = 1;
    // Cannot fail before 2^64 - 2 rings were left unheard.
    [[maybe_unused]] const ssize_t written = write(event_fd, &one, sizeof one);
  }
};

}  // namespace strobe::firmware
