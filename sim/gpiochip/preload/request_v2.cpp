#include "sim/gpiochip/preload/request_v2.hpp"

#include <errno.h>
#include <fcntl.h>

#include "sim/gpiochip/debounce.hpp"
#include "sim/gpiochip/levels.hpp"
#include "sim/gpiochip/preload/device.hpp"
#include "sim/gpiochip/preload/line_config.hpp"
#include "sim/gpiochip/preload/lines.hpp"
#include "sim/gpiochip/rig_time.hpp"
#include "sim/gpiochip/system.hpp"
#include "sim/gpiochip/watches.hpp"

namespace strobe::sim::gpio {
namespace {

constexpr std::uint32_t kEventsPerLine = 16;
constexpr std::uint32_t kMaxEvents = GPIO_V2_LINES_MAX * kEventsPerLine;
constexpr std::uint32_t kEdges = ConfigWord::kRising | ConfigWord::kFalling;

/// The kernel rounds the size of a queue up to a power of two.
std::uint32_t event_depth(const gpio_v2_line_request& request) {
  std::uint32_t asked = request.event_buffer_size;
  if (asked == 0) asked = request.num_lines * kEventsPerLine;
  if (asked > kMaxEvents) asked = kMaxEvents;
  std::uint32_t depth = 1;
  while (depth < asked) depth *= 2;
  return depth;
}

int check_request(const gpio_v2_line_request& request) {
  if (request.num_lines == 0 || request.num_lines > GPIO_V2_LINES_MAX) return -EINVAL;
  for (const std::uint32_t word : request.padding)
    if (word != 0) return -EINVAL;
  return check_config(request.config, request.num_lines);
}

std::uint32_t owner_of(std::uint32_t slot) {
  return ConfigWord::kRequested | ConfigWord::kVersion2 | slot << ConfigWord::kSlotShift;
}

/// As the kernel configures one line, in its order: the direction first, then what its edges need.
int configure(State& state, std::uint32_t slot, std::uint32_t index, std::uint32_t line,
              const gpio_v2_line_config& config, std::int64_t now_ns) {
  const LineSetting setting = setting_of(config, index);
  configure_line(state, line, setting, owner_of(slot), now_ns);
  // The kernel makes no queue of one event.
  if ((setting.flags & kEdges) != 0 && state.handles[slot].event_depth.load() < 2) return -EINVAL;
  set_debounce(state, line, debounce_us_of(config, index));
  return 0;
}

void fill_slot(State& state, std::uint32_t slot, const gpio_v2_line_request& request) {
  Handle& handle = state.handles[slot];
  handle.serial.store(state.last_serial.fetch_add(1) + 1);
  handle.count.store(request.num_lines);
  handle.seqno.store(0);
  handle.event_depth.store(event_depth(request));
  for (std::uint32_t i = 0; i < request.num_lines; ++i) {
    handle.lines[i].store(static_cast<std::uint8_t>(request.offsets[i]));
  }
}

int take_one(State& state, const ChipLock& lock, std::uint32_t slot, std::uint32_t index,
             const gpio_v2_line_request& request, std::int64_t now_ns) {
  const std::uint32_t line = request.offsets[index];
  if (line >= state.line_count) return -EINVAL;
  int result = check_free(state, lock, line);
  if (result == 0) result = check_bias(state, setting_of(request.config, index).flags);
  if (result != 0) return result;
  name_owner(state, line, request.consumer);
  state.lines[line].seqno.store(0);
  const int configured = configure(state, slot, index, line, request.config, now_ns);
  if (configured == 0) tell_watchers(state, device().folder, line, GPIO_V2_LINE_CHANGED_REQUESTED);
  return configured;
}

/// Lets go of the lines that a request had taken before it failed.
void release_taken(State& state, std::uint32_t slot, const gpio_v2_line_request& request) {
  for (std::uint32_t i = 0; i < request.num_lines; ++i) {
    const std::uint32_t line = request.offsets[i];
    if (line >= state.line_count) continue;
    const std::uint32_t config = state.lines[line].config.load();
    const bool taken = (config & owner_of(slot)) == owner_of(slot) && ConfigWord::slot(config) == slot;
    if (taken) release_line(state, device().folder, line);
  }
}

int take_lines(State& state, const ChipLock& lock, std::uint32_t slot, const gpio_v2_line_request& request) {
  const std::int64_t now = now_ns(state);
  for (std::uint32_t i = 0; i < request.num_lines; ++i) {
    const int result = take_one(state, lock, slot, i, request, now);
    if (result == 0) continue;
    release_taken(state, slot, request);
    return result;
  }
  return 0;
}

int open_events(std::uint32_t slot) {
  char path[kPathSize];
  if (!numbered_path(device().folder, kRequestPrefix, slot, path)) return -ENAMETOOLONG;
  return sys::open(path, O_RDONLY | O_NONBLOCK | O_CLOEXEC);
}

/// The slot's FIFO, its lock and its lines become the request's.
int take_slot(State& state, const ChipLock& lock, std::uint32_t slot, const gpio_v2_line_request& request,
              int fd) {
  const EmitLock quiet_queue(lock.lock_fd(), slot);
  if (!quiet_queue.held()) return quiet_queue.error();
  const int locked = sys::try_lock(fd, 0, false);
  if (locked != 0) return locked;
  drain(fd);
  fill_slot(state, slot, request);
  state.record_sizes.fetch_or(RecordSizes::kEvent);
  const int result = take_lines(state, lock, slot, request);
  return result != 0 ? result : sys::control(fd, F_SETFL, 0);
}

}  // namespace

int request_lines(gpio_v2_line_request& request) {
  State& state = *device().state;
  const int invalid = check_request(request);
  if (invalid != 0) return invalid;

  const sys::NoSignals quiet;
  const ChipLock lock(device().folder);
  if (lock.error() != 0) return lock.error();
  std::uint32_t slot = 0;
  const int found = free_slot(state, lock, slot);
  if (found != 0) return found;
  const int fd = open_events(slot);
  if (fd < 0) return fd;
  gpio_v2_line_request named = request;
  named.consumer[sizeof(named.consumer) - 1] = '\0';
  return finish_request(state, take_slot(state, lock, slot, named, fd), fd, request.fd);
}

int configure_lines(std::uint32_t slot, const gpio_v2_line_config& config) {
  State& state = *device().state;
  const Handle& handle = state.handles[slot];
  const int invalid = check_config(config, handle.count.load());
  if (invalid != 0) return invalid;
  const sys::NoSignals quiet;
  const ChipLock lock(device().folder);
  int result = lock.error();
  const std::int64_t now = now_ns(state);
  for (std::uint32_t i = 0; result == 0 && i < handle.count.load(); ++i) {
    // A line without a direction stays as it is.
    if (setting_of(config, i).direction == Direction::as_is) continue;
    const std::uint32_t line = handle.lines[i].load();
    result = check_bias(state, setting_of(config, i).flags);
    if (result == 0) result = configure(state, slot, i, line, config, now);
    if (result == 0) tell_watchers(state, device().folder, line, GPIO_V2_LINE_CHANGED_CONFIG);
  }
  notify(state);
  return result;
}

}  // namespace strobe::sim::gpio
