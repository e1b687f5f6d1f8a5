// A wake-up through an eventfd: the thread that sleeps polls the descriptor. Thread-safe, real-time safe.
#pragma once

#include <sys/eventfd.h>
#include <unistd.h>

#include <cstdint>

#include "firmware/ports/wake.hpp"

namespace strobe::firmware {

class EventFd final : public Wake {
 public:
  EventFd() : fd_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {}
  EventFd(const EventFd&) = delete;
  EventFd& operator=(const EventFd&) = delete;
  ~EventFd() override { close(fd_); }

  bool wake() noexcept override {
    const std::uint64_t one = 1;
    // Cannot block before 2^64 - 2 wakes were left unread.
    return write(fd_, &one, sizeof one) == sizeof one;
  }
  /// Wakes since the last call.
  std::uint64_t take() noexcept {
    std::uint64_t count = 0;
    return read(fd_, &count, sizeof count) == sizeof count ? count : 0;
  }
  int fd() const { return fd_; }

 private:
  int fd_;
};

}  // namespace strobe::firmware
