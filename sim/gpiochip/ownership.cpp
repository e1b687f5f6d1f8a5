#include "sim/gpiochip/ownership.hpp"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>

#include "sim/gpiochip/levels.hpp"
#include "sim/gpiochip/rig_time.hpp"
#include "sim/gpiochip/system.hpp"
#include "sim/gpiochip/watches.hpp"

namespace strobe::sim::gpio {
namespace {

constexpr std::int64_t kLockTimeout_ns = 2'000'000'000;

/// Waits for a lock, as long as a holder that is not stopped can need.
int lock_within_limit(int fd, std::int64_t byte, std::int64_t pause_ns) {
  const std::int64_t give_up = sys::now_ns() + kLockTimeout_ns;
  for (;;) {
    const int result = sys::try_lock(fd, byte, true);
    if (result != -EAGAIN || sys::now_ns() >= give_up) return result;
    sys::sleep_ns(pause_ns);
    if (pause_ns < 1'000'000) pause_ns *= 2;
  }
}

/// Spares owners that took the line between the check without the lock and the check with it.
bool is_orphan(const State& state, const char* folder, int lock_fd, std::uint32_t line) {
  const std::uint32_t config = state.lines[line].config.load();
  return (config & ConfigWord::kRequested) != 0 && !owner_lives(folder, lock_fd, line, config);
}

}  // namespace

bool path_in(const char* folder, const char* name, char (&path)[kPathSize]) {
  const int length = snprintf(path, sizeof(path), "%s/%s", folder, name);
  return length > 0 && static_cast<std::size_t>(length) < sizeof(path);
}

bool numbered_path(const char* folder, const char* prefix, std::uint32_t number, char (&path)[kPathSize]) {
  const int length = snprintf(path, sizeof(path), "%s/%s%u", folder, prefix, number);
  return length > 0 && static_cast<std::size_t>(length) < sizeof(path);
}

ChipLock::ChipLock(const char* folder) {
  char path[kPathSize];
  if (!path_in(folder, kLockFile, path)) {
    error_ = -ENAMETOOLONG;
    return;
  }
  fd_ = sys::open(path, O_RDWR | O_CLOEXEC);
  if (fd_ < 0) {
    error_ = fd_;
    return;
  }
  error_ = lock_within_limit(fd_, kChipLockByte, 20'000);
}

ChipLock::~ChipLock() {
  if (fd_ < 0) return;
  // Unlocked by hand: a child forked meanwhile by another thread shares the description.
  if (error_ == 0) sys::unlock(fd_, kChipLockByte);
  sys::close(fd_);
}

EmitLock::EmitLock(int lock_fd, std::uint32_t slot)
    : fd_(lock_fd), byte_(kEmitByte + slot), error_(lock_within_limit(fd_, byte_, 1'000)) {}

EmitLock::~EmitLock() {
  if (held()) sys::unlock(fd_, byte_);
}

bool owner_lives(const char* folder, int lock_fd, std::uint32_t line, std::uint32_t config) {
  const bool version2 = (config & ConfigWord::kVersion2) != 0;
  if (!version2 && (config & ConfigWord::kEvents) == 0) return sys::is_locked(lock_fd, line);
  char path[kPathSize];
  const bool named = version2 ? numbered_path(folder, kRequestPrefix, ConfigWord::slot(config), path)
                              : numbered_path(folder, kEventPrefix, line, path);
  if (!named) return false;
  const int fifo = sys::open(path, O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (fifo < 0) return true;  // cannot tell, e.g. out of descriptors: better busy than stolen
  const bool locked = sys::is_locked(fifo, 0);
  sys::close(fifo);
  return locked;
}

void release_line(State& state, const char* folder, std::uint32_t line) {
  Line& entry = state.lines[line];
  std::uint32_t config = entry.config.load() & ConfigWord::kKeptByRelease;
  if (state.input_on_release != 0) {
    change_line(state, line, float_edit(), Cause::release, now_ns(state));
    config &= ~ConfigWord::kIsOut;
  }
  set_consumer(entry, "");
  entry.debounce_us.store(0);
  entry.config.store(config);
  tell_watchers(state, folder, line, GPIO_V2_LINE_CHANGED_RELEASED);
  notify(state);
}

void reap_line_locked(State& state, const char* folder, const ChipLock& lock, std::uint32_t line) {
  if (is_orphan(state, folder, lock.lock_fd(), line)) release_line(state, folder, line);
}

void reap_line(State& state, const char* folder, int lock_fd, std::uint32_t line) {
  if (!is_orphan(state, folder, lock_fd, line)) return;
  const sys::NoSignals quiet;
  const ChipLock lock(folder);
  if (lock.error() == 0) reap_line_locked(state, folder, lock, line);
}

void reap_outputs(State& state, const char* folder, int lock_fd) {
  for (std::uint32_t line = 0; line < state.line_count; ++line) {
    if ((state.lines[line].config.load() & ConfigWord::kIsOut) != 0) reap_line(state, folder, lock_fd, line);
  }
}

void reap_watched(State& state, const char* folder, int lock_fd) {
  const std::uint64_t watched = watched_lines(state);
  for (std::uint32_t line = 0; watched != 0 && line < state.line_count; ++line) {
    if ((watched >> line & 1) != 0) reap_line(state, folder, lock_fd, line);
  }
}

bool any_requested(const State& state) {
  for (std::uint32_t line = 0; line < state.line_count; ++line) {
    if ((state.lines[line].config.load() & ConfigWord::kRequested) != 0) return true;
  }
  return false;
}

void set_consumer(Line& line, const char* text) {
  std::uint64_t words[kNameSize / 8] = {};
  memcpy(words, text, strnlen(text, kNameSize - 1));
  for (std::size_t i = 0; i < kNameSize / 8; ++i) line.consumer[i].store(words[i]);
}

void get_consumer(const Line& line, char (&text)[kNameSize]) {
  std::uint64_t words[kNameSize / 8];
  for (std::size_t i = 0; i < kNameSize / 8; ++i) words[i] = line.consumer[i].load();
  memcpy(text, words, kNameSize);
  text[kNameSize - 1] = '\0';
}

}  // namespace strobe::sim::gpio
