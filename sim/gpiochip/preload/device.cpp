#include "sim/gpiochip/preload/device.hpp"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <atomic>

#include "sim/gpiochip/preload/lines.hpp"
#include "sim/gpiochip/system.hpp"

namespace strobe::sim::gpio {
namespace {

constexpr const char* kVariable = "STROBE_GPIOCHIP_DIR";

State* map_state(const char* folder, const char*& problem) {
  char path[kPathSize];
  problem = "no simulated chip there";
  if (!path_in(folder, kStateFile, path)) return nullptr;
  const int fd = sys::open(path, O_RDWR | O_CLOEXEC);
  if (fd == -EACCES) problem = "permission denied";
  if (fd < 0) return nullptr;
  const bool whole = sys::seek(fd, 0, SEEK_END) == static_cast<std::int64_t>(sizeof(State));
  void* memory = whole ? sys::map_shared(fd, sizeof(State)) : nullptr;
  sys::close(fd);
  problem = "not a chip of this version";
  if (memory == nullptr) return nullptr;
  auto* state = static_cast<State*>(memory);
  if (state->magic.load() == kMagic && state->version == kVersion) return state;
  sys::unmap(memory, sizeof(State));
  return nullptr;
}

Device open_device() {
  Device found;
  const char* named = getenv(kVariable);
  if (named == nullptr) return found;
  const char* problem = "no such folder";
  // Made absolute now: the program may change its folder.
  char whole[PATH_MAX];
  if (realpath(named, whole) != nullptr && strlen(whole) < sizeof(found.folder)) {
    memcpy(found.folder, whole, strlen(whole) + 1);
    found.state = map_state(found.folder, problem);
  }
  if (found.state == nullptr) {
    found.wrong = true;
    char line[kPathSize + 128];
    const int length =
        snprintf(line, sizeof(line), "strobe-gpiochip: %s=%s: %s\n", kVariable, named, problem);
    if (length > 0) sys::write(STDERR_FILENO, line, strnlen(line, sizeof(line)));
    return found;
  }
  snprintf(found.node, sizeof(found.node), "/dev/%s", found.state->name);
  snprintf(found.sysfs, sizeof(found.sysfs), "/sys/bus/gpio/devices/%s/dev", found.state->name);
  return found;
}

Descriptor request_of(const State& state, const sys::FileId& id) {
  for (std::uint32_t slot = 0; slot < state.line_count; ++slot) {
    if (id.inode == state.request_inodes[slot]) return {Kind::request, slot};
  }
  return {};
}

Descriptor chip_of(const State& state, const sys::FileId& id) {
  for (std::uint32_t watcher = 0; watcher < kMaxWatchers; ++watcher) {
    if (id.inode == state.watch_inodes[watcher]) return {Kind::chip, watcher};
  }
  return {};
}

/// -EBUSY if another open of the chip has it. Chip's lock held.
int open_watcher(State& state, std::uint32_t index, int flags) {
  char path[kPathSize];
  if (!numbered_path(device().folder, kWatchPrefix, index, path)) return -ENAMETOOLONG;
  const int fd = sys::open(path, flags | O_NONBLOCK);
  if (fd < 0) return fd;
  int result = sys::is_locked(fd, 0) ? -EBUSY : sys::try_lock(fd, 0, false);
  if (result == 0) {
    state.watchers[index].lines.store(0);
    state.watchers[index].version.store(0);
    drain(fd);
    result = sys::control(fd, F_SETFL, flags & O_NONBLOCK);
  }
  if (result == 0) return fd;
  sys::close(fd);
  return result;
}

std::atomic<const Device*> mapped_device{nullptr};

/// Mapped before main, so that the first use is not the slow one.
__attribute__((constructor)) void map_early() { mapped_device.store(&device(), std::memory_order_release); }

}  // namespace

const Device& device() {
  static const Device opened = open_device();
  return opened;
}

const Device* mapped_device_or_null() { return mapped_device.load(std::memory_order_acquire); }

bool present() { return device().state != nullptr && device().state->unplugged.load() == 0; }

Node node_of(const char* path) {
  const Device& known = device();
  if (path == nullptr) return Node::other;
  if (known.wrong) return strncmp(path, "/dev/gpiochip", 13) == 0 ? Node::missing : Node::other;
  if (known.state == nullptr) return Node::other;
  if (strcmp(path, known.node) == 0) return present() ? Node::device : Node::missing;
  if (strcmp(path, known.sysfs) == 0) return present() ? Node::sysfs : Node::missing;
  return Node::other;
}

Descriptor describe(int fd) {
  const State* state = device().state;
  if (state == nullptr || fd < 0) return {};
  const std::int64_t offset = sys::seek(fd, 0, SEEK_CUR);
  if (offset >= HandleName::kBase) {
    const HandleName name = HandleName::of(offset);
    if (state->handles[name.slot].serial.load() == name.serial) return {Kind::handle, name.slot};
  }
  sys::FileId id;
  if (sys::identify(fd, id) != 0 || id.device != state->folder_device) return {};
  if (id.inode == state->device_inode) return {Kind::chip, kMaxWatchers};
  for (std::uint32_t line = 0; line < state->line_count; ++line) {
    if (id.inode == state->lines[line].fifo_inode) return {Kind::event, line};
  }
  const Descriptor request = request_of(*state, id);
  return request.kind != Kind::none ? request : chip_of(*state, id);
}

Descriptor describe_request_first(int fd) {
  const State* state = device().state;
  sys::FileId id;
  if (state != nullptr && sys::identify(fd, id) == 0 && id.device == state->folder_device) {
    const Descriptor request = request_of(*state, id);
    if (request.kind != Kind::none) return request;
  }
  return describe(fd);
}

int open_chip(int flags) {
  // Read-only, whatever was asked for: who could write to its FIFO would never see its end.
  flags &= ~O_ACCMODE;
  State* state = device().state;
  if (state == nullptr) return -ENODEV;
  const sys::NoSignals quiet;
  const ChipLock lock(device().folder);
  for (std::uint32_t i = 0; lock.error() == 0 && i < kMaxWatchers; ++i) {
    const int fd = open_watcher(*state, i, flags);
    if (fd != -EBUSY) return fd;
  }
  char path[kPathSize];
  return path_in(device().folder, kDeviceFile, path) ? sys::open(path, flags) : -ENAMETOOLONG;
}

}  // namespace strobe::sim::gpio
