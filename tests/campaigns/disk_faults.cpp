#include "tests/campaigns/disk_faults.hpp"

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

bool fails(const std::optional<DiskFault>& fault) {
  if (fault) errno = fault->error;
  return fault.has_value();
}

/// Calls the function with the name and the value of each.
template <typename Fault, typename Function>
void each_field(Fault& fault, const Function& function) {
  function("folder", fault.folder);
  function("file", fault.file);
  function("call", fault.call);
  function("nth", fault.nth);
  function("times", fault.times);
  function("error", fault.error);
  function("short", fault.short_bytes);
  function("truncate_too", fault.truncate_too);
}
void read(const std::string& text, std::string& field) { field = text; }
template <typename Number>
void read(const std::string& text, Number& field) {
  field = static_cast<Number>(std::atoi(text.c_str()));
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
  DiskFault fault;
  std::istringstream parts(text);
  for (std::string part; std::getline(parts, part, ',');) {
    const std::size_t at = part.find('=');
    if (at == part.npos) return std::nullopt;
    each_field(fault, [key = part.substr(0, at), value = part.substr(at + 1)](const char* name, auto& field) {
      if (key == name) read(value, field);
    });
  }
  return fault.call.empty() ? std::nullopt : std::optional(fault);
}

std::string to_text(const DiskFault& fault) {
  std::ostringstream text;
  each_field(fault, [&text](const char* name, const auto& field) {
    text << (text.tellp() > 0 ? "," : "") << name << "=" << field;
  });
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
using strobe::testing::fails;

void* operator new(std::size_t size) {
  void* memory = strobe::testing::memory_refuses() ? nullptr : std::malloc(size == 0 ? 1 : size);
  if (!memory) throw std::bad_alloc();
  return memory;
}

void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace {

template <typename... Arguments>
int call_system(long number, Arguments... arguments) {
  return static_cast<int>(syscall(number, arguments...));
}

}  // namespace

extern "C" {

ssize_t write(int fd, const void* data, size_t size) {
  const auto fault = due_on("write", fd);
  const auto some = fault ? std::min<size_t>(static_cast<size_t>(fault->short_bytes), size) : size;
  if (fault && some == 0) return fails(fault) ? -1 : 0;
  return syscall(SYS_write, fd, data, some);  // the rest comes, and fails, in a call of its own
}

int fsync(int fd) { return fails(due_on("fsync", fd)) ? -1 : call_system(SYS_fsync, fd); }

int close(int fd) {
  const auto fault = due_on("close", fd);
  const int done = call_system(SYS_close, fd);
  return fails(fault) ? -1 : done;  // the descriptor is gone all the same
}

int ftruncate(int fd, off_t size) noexcept {
  return fails(due_on("truncate", fd)) ? -1 : call_system(SYS_ftruncate, fd, size);
}
int ftruncate64(int fd, off64_t size) noexcept { return ftruncate(fd, size); }

// <fcntl.h> has a struct of that name.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wshadow"
int flock(int fd, int operation) noexcept {
  return fails(due_on("flock", fd)) ? -1 : call_system(SYS_flock, fd, operation);
}
#pragma GCC diagnostic pop

int rename(const char* from, const char* to) noexcept {
  return fails(due_at("rename", to)) ? -1 : call_system(SYS_renameat2, AT_FDCWD, from, AT_FDCWD, to, 0);
}

int link(const char* from, const char* to) noexcept {
  return fails(due_at("link", to)) ? -1 : call_system(SYS_linkat, AT_FDCWD, from, AT_FDCWD, to, 0);
}

int open(const char* path, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(more, mode_t) : 0;
  va_end(more);
  if ((flags & (O_WRONLY | O_RDWR)) != 0 && fails(due_at("open", path))) return -1;
  return call_system(SYS_openat, AT_FDCWD, path, flags, mode);
}
int open64(const char* path, int flags, ...) __attribute__((alias("open")));

}  // extern "C"
