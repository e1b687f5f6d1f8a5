// Ownership of a line: an open file description that holds a lock, so that the kernel itself releases it at
// close() and at any process's death. A line of a handle is owned by a lock on its byte of the lock file, an
// event line and the lines of a v2 request by a lock on their FIFO; all are shared locks (descriptors are
// read-only, as the kernel's are), exclusive by the chip's lock.
//
// A released line is detected by the next process that looks: it then restores the chip's configuration
// ("reaps").
#pragma once

#include <cstddef>
#include <cstdint>

#include "sim/gpiochip/state.hpp"

namespace strobe::sim::gpio {

inline constexpr std::size_t kPathSize = 4096;

/// DIR/name into `path`; false if it does not fit.
bool path_in(const char* folder, const char* name, char (&path)[kPathSize]);
/// The same for one of the FIFOs: DIR/<prefix><number>.
bool numbered_path(const char* folder, const char* prefix, std::uint32_t number, char (&path)[kPathSize]);

/// Serialises requests, releases and configuration between all processes. Held by a lock that the kernel
/// drops at death; a holder that is stopped (not dead) makes others give up after two seconds.
class ChipLock {
 public:
  explicit ChipLock(const char* folder);
  ~ChipLock();
  ChipLock(const ChipLock&) = delete;
  ChipLock& operator=(const ChipLock&) = delete;

  int error() const { return error_; }  ///< 0 or a negated errno: not held
  int lock_fd() const { return fd_; }

 private:
  int fd_ = -1;
  int error_ = 0;
};

/// Held while one event of a v2 request is numbered and queued, and while its queue passes to a next request.
/// Taken after the chip's lock, never before. `lock_fd`: any description of the lock file that owns nothing.
class EmitLock {
 public:
  EmitLock(int lock_fd, std::uint32_t slot);
  ~EmitLock();
  EmitLock(const EmitLock&) = delete;
  EmitLock& operator=(const EmitLock&) = delete;

  bool held() const { return error_ == 0; }
  int error() const { return error_; }

 private:
  int fd_ = -1;
  std::int64_t byte_ = 0;
  int error_ = 0;
};

/// Whether the line's owner is still alive. `lock_fd`: any description of the lock file that owns nothing.
bool owner_lives(const char* folder, int lock_fd, std::uint32_t line, std::uint32_t config);

/// Restores a released line: unrequested, flags cleared, and, on chips of that kind, an input again. Lock
/// held.
void release_line(State& state, const char* folder, std::uint32_t line);

/// Releases the line if its owner is gone. Takes the lock itself, and only then.
void reap_line(State& state, const char* folder, int lock_fd, std::uint32_t line);
/// The same for all outputs; an input's release changes no level and can wait until that line is used, unless
/// somebody watches it.
void reap_outputs(State& state, const char* folder, int lock_fd);
void reap_watched(State& state, const char* folder, int lock_fd);
/// The same for one line with the lock held.
void reap_line_locked(State& state, const char* folder, const ChipLock& lock, std::uint32_t line);

bool any_requested(const State& state);

void set_consumer(Line& line, const char* text);
void get_consumer(const Line& line, char (&text)[kNameSize]);

/// A handle's descriptor names its slot and serial by its file offset, which dup and fork share with it.
struct HandleName {
  std::uint32_t slot = 0;
  std::uint32_t serial = 0;

  static constexpr std::int64_t kBase = std::int64_t{1} << 42;  // past every real file, within ext4's limit
  constexpr std::int64_t offset() const { return kBase + std::int64_t{serial} * kMaxLines + slot; }
  static constexpr HandleName of(std::int64_t offset) {
    const auto number = static_cast<std::uint64_t>(offset - kBase);
    return {static_cast<std::uint32_t>(number % kMaxLines), static_cast<std::uint32_t>(number / kMaxLines)};
  }
};

}  // namespace strobe::sim::gpio
