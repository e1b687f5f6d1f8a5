#include "sim/gpiochip/preload/request.hpp"

#include <errno.h>
#include <fcntl.h>
#include <string.h>

#include "sim/gpiochip/levels.hpp"
#include "sim/gpiochip/preload/lines.hpp"
#include "sim/gpiochip/rig_time.hpp"
#include "sim/gpiochip/system.hpp"
#include "sim/gpiochip/watches.hpp"

namespace strobe::sim::gpio {
namespace {

constexpr std::uint32_t kBiasFlags =
    GPIOHANDLE_REQUEST_BIAS_PULL_UP | GPIOHANDLE_REQUEST_BIAS_PULL_DOWN | GPIOHANDLE_REQUEST_BIAS_DISABLE;
constexpr std::uint32_t kSingleEnded = GPIOHANDLE_REQUEST_OPEN_DRAIN | GPIOHANDLE_REQUEST_OPEN_SOURCE;
constexpr std::uint32_t kKnownFlags = GPIOHANDLE_REQUEST_INPUT | GPIOHANDLE_REQUEST_OUTPUT |
                                      GPIOHANDLE_REQUEST_ACTIVE_LOW | kSingleEnded | kBiasFlags;

bool one_bias_at_most(std::uint32_t flags) {
  const std::uint32_t bias = flags & kBiasFlags;
  return (bias & (bias - 1)) == 0;
}

bool handle_flags_valid(std::uint32_t flags) {
  const bool input = (flags & GPIOHANDLE_REQUEST_INPUT) != 0;
  const bool output = (flags & GPIOHANDLE_REQUEST_OUTPUT) != 0;
  if ((flags & ~kKnownFlags) != 0 || (input && output)) return false;
  if ((flags & kSingleEnded) != 0 && ((flags & kSingleEnded) == kSingleEnded || !output)) return false;
  if ((flags & kBiasFlags) != 0 && !input && !output) return false;
  return one_bias_at_most(flags);
}

bool event_flags_valid(std::uint32_t flags, std::uint32_t edges) {
  constexpr std::uint32_t kEdges = GPIOEVENT_REQUEST_RISING_EDGE | GPIOEVENT_REQUEST_FALLING_EDGE;
  if ((flags & ~kKnownFlags) != 0 || (edges & ~kEdges) != 0) return false;
  return (flags & (GPIOHANDLE_REQUEST_OUTPUT | kSingleEnded)) == 0 && one_bias_at_most(flags);
}

std::uint32_t config_flags(std::uint32_t flags) {
  std::uint32_t config = 0;
  if ((flags & GPIOHANDLE_REQUEST_ACTIVE_LOW) != 0) config |= ConfigWord::kActiveLow;
  if ((flags & GPIOHANDLE_REQUEST_OPEN_DRAIN) != 0) config |= ConfigWord::kOpenDrain;
  if ((flags & GPIOHANDLE_REQUEST_OPEN_SOURCE) != 0) config |= ConfigWord::kOpenSource;
  if ((flags & GPIOHANDLE_REQUEST_BIAS_PULL_UP) != 0) config |= ConfigWord::kPullUp;
  if ((flags & GPIOHANDLE_REQUEST_BIAS_PULL_DOWN) != 0) config |= ConfigWord::kPullDown;
  if ((flags & GPIOHANDLE_REQUEST_BIAS_DISABLE) != 0) config |= ConfigWord::kBiasDisable;
  return config;
}

LineSetting setting_of(std::uint32_t flags, unsigned value) {
  Direction direction = Direction::as_is;
  if ((flags & GPIOHANDLE_REQUEST_OUTPUT) != 0) direction = Direction::output;
  if ((flags & GPIOHANDLE_REQUEST_INPUT) != 0) direction = Direction::input;
  return {config_flags(flags), direction, value};
}

/// The line's owner is `fd` from now on. -EBUSY if it has another.
int take_line(State& state, const ChipLock& lock, std::uint32_t line, int fd, std::int64_t byte,
              const char* label) {
  int result = check_free(state, lock, line);
  if (result == 0) result = sys::try_lock(fd, byte, false);
  if (result == 0) name_owner(state, line, label);
  return result;
}

int new_handle(State& state, const ChipLock& lock, const gpiohandle_request& request, HandleName& name) {
  const int result = free_slot(state, lock, name.slot);
  if (result != 0) return result;
  name.serial = state.last_serial.fetch_add(1) + 1;
  Handle& handle = state.handles[name.slot];
  for (std::uint32_t i = 0; i < request.lines; ++i) {
    handle.lines[i].store(static_cast<std::uint8_t>(request.lineoffsets[i]));
  }
  handle.count.store(request.lines);
  handle.serial.store(name.serial);
  return 0;
}

int open_handle(const HandleName& name) {
  char path[kPathSize];
  if (!path_in(device().folder, kLockFile, path)) return -ENAMETOOLONG;
  const int fd = sys::open(path, O_RDONLY | O_CLOEXEC);
  if (fd < 0) return fd;
  if (sys::seek(fd, name.offset(), SEEK_SET) == name.offset()) return fd;
  sys::close(fd);
  return -EIO;
}

int take_handle_lines(State& state, const ChipLock& lock, const gpiohandle_request& request,
                      const HandleName& name, int fd) {
  const std::uint32_t owner = ConfigWord::kRequested | name.slot << ConfigWord::kSlotShift;
  const std::int64_t now = now_ns(state);
  for (std::uint32_t i = 0; i < request.lines; ++i) {
    const std::uint32_t line = request.lineoffsets[i];
    int result = line < state.line_count ? 0 : -EINVAL;
    if (result == 0) result = check_bias(state, config_flags(request.flags));
    if (result == 0) result = take_line(state, lock, line, fd, line, request.consumer_label);
    if (result != 0) {
      for (std::uint32_t done = 0; done < i; ++done)
        release_line(state, device().folder, request.lineoffsets[done]);
      return result;
    }
    configure_line(state, line, setting_of(request.flags, request.default_values[i]), owner, now);
    tell_watchers(state, device().folder, line, GPIO_V2_LINE_CHANGED_REQUESTED);
  }
  return 0;
}

int open_event(std::uint32_t line) {
  char path[kPathSize];
  if (!numbered_path(device().folder, kEventPrefix, line, path)) return -ENAMETOOLONG;
  return sys::open(path, O_RDONLY | O_NONBLOCK | O_CLOEXEC);
}

int take_event_line(State& state, const ChipLock& lock, const gpioevent_request& request, int fd) {
  const std::uint32_t line = request.lineoffset;
  int result = check_bias(state, config_flags(request.handleflags));
  if (result == 0) result = take_line(state, lock, line, fd, 0, request.consumer_label);
  if (result != 0) return result;
  drain(fd);
  std::uint32_t owner = ConfigWord::kRequested | ConfigWord::kEvents;
  if ((request.eventflags & GPIOEVENT_REQUEST_RISING_EDGE) != 0) owner |= ConfigWord::kRising;
  if ((request.eventflags & GPIOEVENT_REQUEST_FALLING_EDGE) != 0) owner |= ConfigWord::kFalling;
  const LineSetting setting = setting_of(request.handleflags | GPIOHANDLE_REQUEST_INPUT, 0);
  configure_line(state, line, setting, owner, now_ns(state));
  tell_watchers(state, device().folder, line, GPIO_V2_LINE_CHANGED_REQUESTED);
  return sys::control(fd, F_SETFL, 0);
}

}  // namespace

int request_handle(gpiohandle_request& request) {
  State& state = *device().state;
  if (request.lines == 0 || request.lines > GPIOHANDLES_MAX) return -EINVAL;
  if (!handle_flags_valid(request.flags)) return -EINVAL;
  request.consumer_label[sizeof(request.consumer_label) - 1] = '\0';

  const sys::NoSignals quiet;
  const ChipLock lock(device().folder);
  if (lock.error() != 0) return lock.error();
  HandleName name;
  int result = new_handle(state, lock, request, name);
  if (result != 0) return result;
  const int fd = open_handle(name);
  if (fd < 0) return fd;
  result = take_handle_lines(state, lock, request, name, fd);
  return finish_request(state, result, fd, request.fd);
}

int request_event(gpioevent_request& request) {
  State& state = *device().state;
  if (request.lineoffset >= state.line_count) return -EINVAL;
  if (!event_flags_valid(request.handleflags, request.eventflags)) return -EINVAL;
  request.consumer_label[sizeof(request.consumer_label) - 1] = '\0';

  const sys::NoSignals quiet;
  const ChipLock lock(device().folder);
  if (lock.error() != 0) return lock.error();
  const int fd = open_event(request.lineoffset);
  if (fd < 0) return fd;
  const int result = take_event_line(state, lock, request, fd);
  return finish_request(state, result, fd, request.fd);
}

int configure_handle(std::uint32_t slot, const gpiohandle_config& config) {
  State& state = *device().state;
  constexpr std::uint32_t kDirections = GPIOHANDLE_REQUEST_INPUT | GPIOHANDLE_REQUEST_OUTPUT;
  if (!handle_flags_valid(config.flags) || (config.flags & kDirections) == 0) return -EINVAL;
  const sys::NoSignals quiet;
  const ChipLock lock(device().folder);
  if (lock.error() != 0) return lock.error();
  const int refused = check_bias(state, config_flags(config.flags));
  if (refused != 0) return refused;
  const Handle& handle = state.handles[slot];
  const std::uint32_t owner = ConfigWord::kRequested | slot << ConfigWord::kSlotShift;
  const std::int64_t now = now_ns(state);
  for (std::uint32_t i = 0; i < handle.count.load(); ++i) {
    const std::uint32_t line = handle.lines[i].load();
    configure_line(state, line, setting_of(config.flags, config.default_values[i]), owner, now);
    tell_watchers(state, device().folder, line, GPIO_V2_LINE_CHANGED_CONFIG);
  }
  notify(state);
  return 0;
}

}  // namespace strobe::sim::gpio
