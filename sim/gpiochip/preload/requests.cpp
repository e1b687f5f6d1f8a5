#include "sim/gpiochip/preload/requests.hpp"

#include <errno.h>
#include <fcntl.h>
#include <string.h>

#include "sim/gpiochip/levels.hpp"
#include "sim/gpiochip/preload/device.hpp"
#include "sim/gpiochip/preload/lines.hpp"
#include "sim/gpiochip/rig_time.hpp"
#include "sim/gpiochip/system.hpp"
#include "sim/gpiochip/watches.hpp"

namespace strobe::sim::gpio {
namespace {

// uAPI v2: what a line configuration asks of each of its lines, by defaults and attributes with line masks.

constexpr std::uint64_t kDirections = GPIO_V2_LINE_FLAG_INPUT | GPIO_V2_LINE_FLAG_OUTPUT;
constexpr std::uint64_t kEdgeFlags = GPIO_V2_LINE_FLAG_EDGE_RISING | GPIO_V2_LINE_FLAG_EDGE_FALLING;
constexpr std::uint64_t kDrives = GPIO_V2_LINE_FLAG_OPEN_DRAIN | GPIO_V2_LINE_FLAG_OPEN_SOURCE;
constexpr std::uint64_t kBiases =
    GPIO_V2_LINE_FLAG_BIAS_PULL_UP | GPIO_V2_LINE_FLAG_BIAS_PULL_DOWN | GPIO_V2_LINE_FLAG_BIAS_DISABLED;
constexpr std::uint64_t kClocks = GPIO_V2_LINE_FLAG_EVENT_CLOCK_REALTIME | GPIO_V2_LINE_FLAG_EVENT_CLOCK_HTE;
constexpr std::uint64_t kKnown =
    GPIO_V2_LINE_FLAG_ACTIVE_LOW | kDirections | kEdgeFlags | kDrives | kBiases | kClocks;

bool one_at_most(std::uint64_t flags) { return (flags & (flags - 1)) == 0; }

int check_flags(std::uint64_t flags) {
  if ((flags & ~kKnown) != 0) return -EINVAL;
  // No hardware time stamps, as on kernels built without them.
  if ((flags & GPIO_V2_LINE_FLAG_EVENT_CLOCK_HTE) != 0) return -EOPNOTSUPP;
  const bool input = (flags & GPIO_V2_LINE_FLAG_INPUT) != 0;
  const bool output = (flags & GPIO_V2_LINE_FLAG_OUTPUT) != 0;
  if (input && output) return -EINVAL;
  if ((flags & kEdgeFlags) != 0 && !input) return -EINVAL;
  if ((flags & kDrives) != 0 && (!output || !one_at_most(flags & kDrives))) return -EINVAL;
  if ((flags & kBiases) != 0 && ((!input && !output) || !one_at_most(flags & kBiases))) return -EINVAL;
  return 0;
}

/// The first attribute of that kind whose mask has the line; null if none has.
const gpio_v2_line_attribute* attribute_of(const gpio_v2_line_config& config, std::uint32_t index,
                                           std::uint32_t id) {
  for (std::uint32_t i = 0; i < config.num_attrs; ++i) {
    const gpio_v2_line_config_attribute& entry = config.attrs[i];
    if (entry.attr.id == id && (entry.mask >> index & 1) != 0) return &entry.attr;
  }
  return nullptr;
}

std::uint32_t config_flags(std::uint64_t flags) {
  constexpr struct {
    std::uint64_t from;
    std::uint32_t to;
  } kTable[] = {
      {GPIO_V2_LINE_FLAG_ACTIVE_LOW, ConfigWord::kActiveLow},
      {GPIO_V2_LINE_FLAG_OPEN_DRAIN, ConfigWord::kOpenDrain},
      {GPIO_V2_LINE_FLAG_OPEN_SOURCE, ConfigWord::kOpenSource},
      {GPIO_V2_LINE_FLAG_BIAS_PULL_UP, ConfigWord::kPullUp},
      {GPIO_V2_LINE_FLAG_BIAS_PULL_DOWN, ConfigWord::kPullDown},
      {GPIO_V2_LINE_FLAG_BIAS_DISABLED, ConfigWord::kBiasDisable},
      {GPIO_V2_LINE_FLAG_EDGE_RISING, ConfigWord::kRising},
      {GPIO_V2_LINE_FLAG_EDGE_FALLING, ConfigWord::kFalling},
      {GPIO_V2_LINE_FLAG_EVENT_CLOCK_REALTIME, ConfigWord::kRealtime},
  };
  std::uint32_t config = 0;
  for (const auto& pair : kTable)
    if ((flags & pair.from) != 0) config |= pair.to;
  return config;
}

/// `index`: of the line in its request.
std::uint64_t flags_of(const gpio_v2_line_config& config, std::uint32_t index) {
  const gpio_v2_line_attribute* found = attribute_of(config, index, GPIO_V2_LINE_ATTR_ID_FLAGS);
  return found != nullptr ? found->flags : config.flags;
}

/// As the kernel's gpio_v2_line_config_validate(): 0 or a negated errno.
int check_config(const gpio_v2_line_config& config, std::uint32_t lines) {
  if (config.num_attrs > GPIO_V2_LINE_NUM_ATTRS_MAX) return -EINVAL;
  for (const std::uint32_t word : config.padding)
    if (word != 0) return -EINVAL;
  for (std::uint32_t i = 0; i < lines; ++i) {
    const std::uint64_t flags = flags_of(config, i);
    const int result = check_flags(flags);
    if (result != 0) return result;
    const bool debounced = attribute_of(config, i, GPIO_V2_LINE_ATTR_ID_DEBOUNCE) != nullptr;
    if (debounced && (flags & GPIO_V2_LINE_FLAG_INPUT) == 0) return -EINVAL;
  }
  return 0;
}

LineSetting setting_of(const gpio_v2_line_config& config, std::uint32_t index) {
  const std::uint64_t flags = flags_of(config, index);
  LineSetting setting;
  setting.flags = config_flags(flags);
  if ((flags & GPIO_V2_LINE_FLAG_INPUT) != 0) setting.direction = Direction::input;
  if ((flags & GPIO_V2_LINE_FLAG_OUTPUT) != 0) setting.direction = Direction::output;
  const gpio_v2_line_attribute* values = attribute_of(config, index, GPIO_V2_LINE_ATTR_ID_OUTPUT_VALUES);
  setting.value = values != nullptr && (values->values >> index & 1) != 0 ? 1 : 0;
  return setting;
}

/// 0: none.
std::uint32_t debounce_us_of(const gpio_v2_line_config& config, std::uint32_t index) {
  const gpio_v2_line_attribute* found = attribute_of(config, index, GPIO_V2_LINE_ATTR_ID_DEBOUNCE);
  return found != nullptr ? found->debounce_period_us : 0;
}

// uAPI v1

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

std::uint32_t config_flags_v1(std::uint32_t flags) {
  std::uint32_t config = 0;
  if ((flags & GPIOHANDLE_REQUEST_ACTIVE_LOW) != 0) config |= ConfigWord::kActiveLow;
  if ((flags & GPIOHANDLE_REQUEST_OPEN_DRAIN) != 0) config |= ConfigWord::kOpenDrain;
  if ((flags & GPIOHANDLE_REQUEST_OPEN_SOURCE) != 0) config |= ConfigWord::kOpenSource;
  if ((flags & GPIOHANDLE_REQUEST_BIAS_PULL_UP) != 0) config |= ConfigWord::kPullUp;
  if ((flags & GPIOHANDLE_REQUEST_BIAS_PULL_DOWN) != 0) config |= ConfigWord::kPullDown;
  if ((flags & GPIOHANDLE_REQUEST_BIAS_DISABLE) != 0) config |= ConfigWord::kBiasDisable;
  return config;
}

LineSetting setting_of_v1(std::uint32_t flags, unsigned value) {
  Direction direction = Direction::as_is;
  if ((flags & GPIOHANDLE_REQUEST_OUTPUT) != 0) direction = Direction::output;
  if ((flags & GPIOHANDLE_REQUEST_INPUT) != 0) direction = Direction::input;
  return {config_flags_v1(flags), direction, value};
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
    if (result == 0) result = check_bias(state, config_flags_v1(request.flags));
    if (result == 0) result = take_line(state, lock, line, fd, line, request.consumer_label);
    if (result != 0) {
      for (std::uint32_t done = 0; done < i; ++done)
        release_line(state, device().folder, request.lineoffsets[done]);
      return result;
    }
    configure_line(state, line, setting_of_v1(request.flags, request.default_values[i]), owner, now);
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
  int result = check_bias(state, config_flags_v1(request.handleflags));
  if (result == 0) result = take_line(state, lock, line, fd, 0, request.consumer_label);
  if (result != 0) return result;
  drain(fd);
  std::uint32_t owner = ConfigWord::kRequested | ConfigWord::kEvents;
  if ((request.eventflags & GPIOEVENT_REQUEST_RISING_EDGE) != 0) owner |= ConfigWord::kRising;
  if ((request.eventflags & GPIOEVENT_REQUEST_FALLING_EDGE) != 0) owner |= ConfigWord::kFalling;
  const LineSetting setting = setting_of_v1(request.handleflags | GPIOHANDLE_REQUEST_INPUT, 0);
  configure_line(state, line, setting, owner, now_ns(state));
  tell_watchers(state, device().folder, line, GPIO_V2_LINE_CHANGED_REQUESTED);
  return sys::control(fd, F_SETFL, 0);
}

// Requests of uAPI v2

constexpr std::uint32_t kEventsPerLine = 16;
constexpr std::uint32_t kMaxEvents = GPIO_V2_LINES_MAX * kEventsPerLine;
constexpr std::uint32_t kWantedEdges = ConfigWord::kRising | ConfigWord::kFalling;

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
  if ((setting.flags & kWantedEdges) != 0 && state.handles[slot].event_depth.load() < 2) return -EINVAL;
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
  constexpr std::uint32_t kOneDirection = GPIOHANDLE_REQUEST_INPUT | GPIOHANDLE_REQUEST_OUTPUT;
  if (!handle_flags_valid(config.flags) || (config.flags & kOneDirection) == 0) return -EINVAL;
  const sys::NoSignals quiet;
  const ChipLock lock(device().folder);
  if (lock.error() != 0) return lock.error();
  const int refused = check_bias(state, config_flags_v1(config.flags));
  if (refused != 0) return refused;
  const Handle& handle = state.handles[slot];
  const std::uint32_t owner = ConfigWord::kRequested | slot << ConfigWord::kSlotShift;
  const std::int64_t now = now_ns(state);
  for (std::uint32_t i = 0; i < handle.count.load(); ++i) {
    const std::uint32_t line = handle.lines[i].load();
    configure_line(state, line, setting_of_v1(config.flags, config.default_values[i]), owner, now);
    tell_watchers(state, device().folder, line, GPIO_V2_LINE_CHANGED_CONFIG);
  }
  notify(state);
  return 0;
}

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
