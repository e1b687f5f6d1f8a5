#include "tests/campaigns/disk_faults.hpp"

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <climits>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <mutex>
#include <new>
#include <sstream>
#include <string_view>

namespace strobe::testing {
namespace {

struct State {
  std::mutex mutex;
  std::optional<DiskFault> fault;
  int seen = 0;
  int injected = 0;
};

State& state() {
  static State* const kept = new State;  // calls come until the process has ended
  return *kept;
}

std::atomic<bool> armed{false};

// Of memory: apart, as the rest allocates.
std::atomic<bool> memory_armed{false};
std::atomic<int> memory_first{0}, memory_last{0}, memory_seen{0}, memory_refused{0};

bool memory_refuses() {
  if (!memory_armed) return false;
  const int number = ++memory_seen;
  const bool refused = number >= memory_first && number <= memory_last;
  if (refused) ++memory_refused;
  return refused;
}

bool concerns(const DiskFault& fault, std::string_view path) {
  return path.starts_with(fault.folder) && path.substr(fault.folder.size()).find(fault.file) != path.npos;
}

/// The fault, if this call is to fail.
std::optional<DiskFault> due(std::string_view call, const char* path) {
  State& now = state();
  const std::lock_guard lock(now.mutex);
  if (!now.fault || !concerns(*now.fault, path)) return std::nullopt;
  DiskFault& fault = *now.fault;
  const bool counted = call == fault.call;
  if (counted) ++now.seen;
  const bool lasts = now.seen >= fault.nth && now.seen < fault.nth + fault.times;
  if (!lasts || (!counted && !(fault.truncate_too && call == "truncate"))) return std::nullopt;
  ++now.injected;
  DiskFault injected = fault;
  if (now.seen > fault.nth) injected.short_bytes = 0;
  return injected;
}

std::optional<DiskFault> due_on(std::string_view call, int fd) {
  if (!armed) return std::nullopt;
  const int before = errno;
  std::array<char, 64> link{};
  std::array<char, PATH_MAX> path{};
  std::snprintf(link.data(), link.size(), "/proc/self/fd/%d", fd);
  const ssize_t size = ::readlink(link.data(), path.data(), path.size() - 1);
  errno = before;
  return size > 0 ? due(call, path.data()) : std::nullopt;
}

std::optional<DiskFault> due_at(std::string_view call, const char* path) {
  return armed ? due(call, path) : std::nullopt;
}

template <typename Function>
Function* next(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

int failing(const DiskFault& fault) {
  errno = fault.error;
  return -1;
}

/// A preloaded program's fault comes from its environment.
const bool kFromEnvironment = [] {
  const char* text = std::getenv("STROBE_DISK_FAULT");
  const auto fault = parse_disk_fault(text ? text : "");
  if (fault) set_disk_fault(*fault);
  return fault.has_value();
}();

}  // namespace

std::optional<DiskFault> parse_disk_fault(const std::string& text) {
  if (text.empty()) return std::nullopt;
  DiskFault fault;
  std::istringstream parts(text);
  for (std::string part; std::getline(parts, part, ',');) {
    const std::size_t at = part.find('=');
    if (at == part.npos) return std::nullopt;
    const std::string key = part.substr(0, at), value = part.substr(at + 1);
    const int number = std::atoi(value.c_str());
    if (key == "folder") fault.folder = value;
    if (key == "file") fault.file = value;
    if (key == "call") fault.call = value;
    if (key == "nth") fault.nth = number;
    if (key == "times") fault.times = number;
    if (key == "error") fault.error = number;
    if (key == "short") fault.short_bytes = number;
    if (key == "truncate_too") fault.truncate_too = number != 0;
  }
  return fault.call.empty() ? std::nullopt : std::optional(fault);
}

std::string to_text(const DiskFault& fault) {
  std::ostringstream text;
  text << "folder=" << fault.folder << ",file=" << fault.file << ",call=" << fault.call
       << ",nth=" << fault.nth << ",times=" << fault.times << ",error=" << fault.error
       << ",short=" << fault.short_bytes << ",truncate_too=" << fault.truncate_too;
  return text.str();
}

void set_disk_fault(const DiskFault& fault) {
  State& now = state();
  const std::lock_guard lock(now.mutex);
  now.fault = fault;
  now.seen = now.injected = 0;
  memory_seen = memory_refused = 0;
  memory_first = fault.nth;
  memory_last = fault.nth + std::min(fault.times, 1000) - 1;
  memory_armed = fault.call == "memory";
  armed = !memory_armed;
}

void clear_disk_fault() {
  State& now = state();
  const std::lock_guard lock(now.mutex);
  now.fault.reset();
  armed = memory_armed = false;
}

int disk_faults_injected() {
  const std::lock_guard lock(state().mutex);
  return state().injected + memory_refused;
}

}  // namespace strobe::testing

using strobe::testing::due_at;
using strobe::testing::due_on;
using strobe::testing::failing;

void* operator new(std::size_t size) {
  void* memory = strobe::testing::memory_refuses() ? nullptr : std::malloc(size == 0 ? 1 : size);
  if (!memory) throw std::bad_alloc();
  return memory;
}

void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace {

mode_t mode_argument(int flags, va_list more) {
  return (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(more, mode_t) : 0;
}

}  // namespace

extern "C" {

ssize_t write(int fd, const void* data, size_t size) {
  if (const auto fault = due_on("write", fd)) {
    const auto some = std::min<size_t>(static_cast<size_t>(fault->short_bytes), size);
    if (some > 0)
      return syscall(SYS_write, fd, data, some);  // the rest comes, and fails, in a call of its own
    return failing(*fault);
  }
  return syscall(SYS_write, fd, data, size);
}

int fsync(int fd) {
  if (const auto fault = due_on("fsync", fd)) return failing(*fault);
  return static_cast<int>(syscall(SYS_fsync, fd));
}

int close(int fd) {
  const auto fault = due_on("close", fd);
  const int done = static_cast<int>(syscall(SYS_close, fd));
  return fault ? failing(*fault) : done;  // the descriptor is gone all the same
}

int ftruncate(int fd, off_t size) noexcept {
  if (const auto fault = due_on("truncate", fd)) return failing(*fault);
  return static_cast<int>(syscall(SYS_ftruncate, fd, size));
}

int ftruncate64(int fd, off64_t size) noexcept { return ftruncate(fd, size); }

// <fcntl.h> has a struct of that name.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wshadow"
int flock(int fd, int operation) noexcept {
  if (const auto fault = due_on("flock", fd)) return failing(*fault);
  return static_cast<int>(syscall(SYS_flock, fd, operation));
}
#pragma GCC diagnostic pop

int rename(const char* from, const char* to) noexcept {
  if (const auto fault = due_at("rename", to)) return failing(*fault);
  return static_cast<int>(syscall(SYS_renameat2, AT_FDCWD, from, AT_FDCWD, to, 0));
}

int link(const char* from, const char* to) noexcept {
  if (const auto fault = due_at("link", to)) return failing(*fault);
  return static_cast<int>(syscall(SYS_linkat, AT_FDCWD, from, AT_FDCWD, to, 0));
}

int open(const char* path, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const mode_t mode = mode_argument(flags, more);
  va_end(more);
  if ((flags & (O_WRONLY | O_RDWR)) != 0) {
    if (const auto fault = due_at("open", path)) return failing(*fault);
  }
  return static_cast<int>(syscall(SYS_openat, AT_FDCWD, path, flags, mode));
}

int open64(const char* path, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const mode_t mode = mode_argument(flags, more);
  va_end(more);
  return open(path, flags, mode);
}

}  // extern "C"
