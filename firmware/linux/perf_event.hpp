// One event of perf_event_open(2), closed with its owner.
#pragma once

#include <linux/perf_event.h>
#include <sys/syscall.h>
#include <sys/types.h>
#include <unistd.h>

#include <utility>

namespace strobe::firmware {

class PerfEvent {
 public:
  /// thread and cpu: -1 stands for all, of one of them. A failure leaves errno, and get() negative.
  PerfEvent(perf_event_attr event, pid_t thread, int cpu)
      : fd_(static_cast<int>(syscall(SYS_perf_event_open, &event, thread, cpu, -1, PERF_FLAG_FD_CLOEXEC))) {}
  PerfEvent(PerfEvent&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  PerfEvent& operator=(PerfEvent&&) = delete;
  ~PerfEvent() {
    if (fd_ >= 0) close(fd_);
  }
  int get() const { return fd_; }

 private:
  int fd_;
};

}  // namespace strobe::firmware
