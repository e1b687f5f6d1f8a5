#include "sim/gpiochip/preload/uapi.hpp"

#include <errno.h>
#include <fcntl.h>
#include <linux/gpio.h>
#include <string.h>

#include "sim/gpiochip/levels.hpp"
#include "sim/gpiochip/preload/device.hpp"
#include "sim/gpiochip/preload/lines.hpp"
#include "sim/gpiochip/preload/requests.hpp"
#include "sim/gpiochip/rig_time.hpp"
#include "sim/gpiochip/system.hpp"
#include "sim/gpiochip/watches.hpp"

namespace strobe::sim::gpio {
namespace {

int chip_info(void* user) {
  const State& state = *device().state;
  gpiochip_info info{};
  memcpy(info.name, state.name, sizeof(info.name));
  memcpy(info.label, state.label, sizeof(info.label));
  info.lines = state.line_count;
  return sys::copy_out(user, &info, sizeof(info));
}

int line_info(void* user) {
  gpioline_info info{};
  const int copied = sys::copy_in(&info, user, sizeof(info));
  if (copied != 0) return copied;
  if (info.line_offset >= device().state->line_count) return -EINVAL;
  reap_before_look(info.line_offset);
  info = to_v1(info_of(*device().state, info.line_offset));
  return sys::copy_out(user, &info, sizeof(info));
}

/// A request whose answer cannot be written back leaves no lines taken.
template <typename Request>
int with_request(void* user, int (*take)(Request&)) {
  Request request{};
  int result = sys::copy_in(&request, user, sizeof(request));
  if (result != 0) return result;
  result = take(request);
  if (result != 0) return result;
  result = sys::copy_out(user, &request, sizeof(request));
  if (result != 0) sys::close(request.fd);
  return result;
}

unsigned logical_level(const State& state, std::uint32_t line) {
  return physical(state.lines[line].config.load(), level_of(state, line));
}

int get_values(const Handle& handle, void* user) {
  if (!plausible(user)) return -EFAULT;
  gpiohandle_data data{};
  const std::uint32_t count = handle.count.load();
  for (std::uint32_t i = 0; i < count; ++i) {
    data.values[i] = static_cast<std::uint8_t>(logical_level(*device().state, handle.lines[i].load()));
  }
  memcpy(user, &data, sizeof(data));
  return 0;
}

int set_values(const Handle& handle, const void* user) {
  State& state = *device().state;
  if ((state.lines[handle.lines[0].load()].config.load() & ConfigWord::kIsOut) == 0) return -EPERM;
  if (!plausible(user)) return -EFAULT;
  const auto* values = static_cast<const std::uint8_t*>(user);
  const std::uint32_t count = handle.count.load();
  const std::int64_t now = now_ns(state);  // one instant: the lines of a handle change together
  bool changed = false;
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t line = handle.lines[i].load();
    const std::uint32_t config = state.lines[line].config.load();
    if ((config & ConfigWord::kIsOut) == 0) continue;  // requested as it was, and it was an input
    changed |= change_line(state, line, output_edit(config, values[i]), Cause::set, now);
  }
  if (changed) notify(state);
  return 0;
}

// uAPI v2, and line-info watches of v1 and v2; `watcher`: of the descriptor, kMaxWatchers if it cannot watch.

std::uint64_t bit(std::uint32_t index) { return std::uint64_t{1} << index; }

int check_settable(const Handle& request, std::uint64_t mask) {
  State& state = *device().state;
  bool any = false;
  for (std::uint32_t i = 0; i < request.count.load(); ++i) {
    if ((mask & bit(i)) == 0) continue;
    any = true;
    if ((state.lines[request.lines[i].load()].config.load() & ConfigWord::kIsOut) == 0) return -EPERM;
  }
  return any ? 0 : -EINVAL;
}

/// The first watch of an open decides the version of its records.
int take_version(Watcher& watcher, std::uint32_t version) {
  std::uint32_t before = 0;
  const bool first = watcher.version.compare_exchange_strong(before, version);
  return first || before == version ? 0 : -EPERM;
}

int start_watch(std::uint32_t index, std::uint32_t line, std::uint32_t version) {
  State& state = *device().state;
  if (index >= kMaxWatchers) return -ENOMEM;
  Watcher& watcher = state.watchers[index];
  const int result = take_version(watcher, version);
  if (result != 0) return result;
  state.record_sizes.fetch_or(version == 2 ? RecordSizes::kInfoChanged : RecordSizes::kInfoChangedV1);
  return (watcher.lines.fetch_or(bit(line)) & bit(line)) != 0 ? -EBUSY : 0;
}

/// An answer that cannot be written back leaves no line watched.
template <typename Info>
int answer_watch(std::uint32_t watcher, std::uint32_t line, const Info& info, void* user) {
  const int result = sys::copy_out(user, &info, sizeof(info));
  if (result != 0) device().state->watchers[watcher].lines.fetch_and(~bit(line));
  return result;
}

/// Reads the question of line_info_v2() and watch_line().
int asked_line(const void* user, std::uint32_t& line) {
  gpio_v2_line_info info{};
  const int copied = sys::copy_in(&info, user, sizeof(info));
  if (copied != 0) return copied;
  for (const std::uint32_t word : info.padding)
    if (word != 0) return -EINVAL;
  line = info.offset;
  return line < device().state->line_count ? 0 : -EINVAL;
}

int line_info_v2(void* user) {
  std::uint32_t line = 0;
  const int result = asked_line(user, line);
  if (result != 0) return result;
  reap_before_look(line);
  const gpio_v2_line_info info = info_of(*device().state, line);
  return sys::copy_out(user, &info, sizeof(info));
}

int get_line_values(std::uint32_t slot, void* user) {
  const State& state = *device().state;
  const Handle& request = state.handles[slot];
  if (!plausible(user)) return -EFAULT;
  gpio_v2_line_values values;
  memcpy(&values, user, sizeof(values));
  const std::uint32_t count = request.count.load();
  const std::uint64_t all = count == kMaxLines ? ~std::uint64_t{0} : bit(count) - 1;
  if ((values.mask & all) == 0) return -EINVAL;
  values.bits = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    if ((values.mask & bit(i)) == 0) continue;
    const std::uint32_t line = request.lines[i].load();
    const unsigned level = is_debounced(state, line) ? debounced_level(state, line, now_ns(*device().state))
                                                     : level_of(state, line);
    if (physical(state.lines[line].config.load(), level) != 0) values.bits |= bit(i);
  }
  memcpy(user, &values, sizeof(values));
  return 0;
}

int set_line_values(std::uint32_t slot, const void* user) {
  State& state = *device().state;
  const Handle& request = state.handles[slot];
  if (!plausible(user)) return -EFAULT;
  gpio_v2_line_values values;
  memcpy(&values, user, sizeof(values));
  const int refused = check_settable(request, values.mask);
  if (refused != 0) return refused;
  const std::int64_t now = now_ns(*device().state);  // one instant: the lines of a call change together
  bool changed = false;
  for (std::uint32_t i = 0; i < request.count.load(); ++i) {
    if ((values.mask & bit(i)) == 0) continue;
    const std::uint32_t line = request.lines[i].load();
    const unsigned value = (values.bits & bit(i)) != 0 ? 1 : 0;
    const PinEdit edit = output_edit(state.lines[line].config.load(), value);
    changed |= change_line(state, line, edit, Cause::set, now);
  }
  if (changed) notify(state);
  return 0;
}

int watch_line(std::uint32_t watcher, void* user) {
  std::uint32_t line = 0;
  int result = asked_line(user, line);
  if (result != 0) return result;
  reap_before_look(line);
  result = start_watch(watcher, line, 2);
  return result != 0 ? result : answer_watch(watcher, line, info_of(*device().state, line), user);
}

int watch_line_v1(std::uint32_t watcher, void* user) {
  gpioline_info asked{};
  int result = sys::copy_in(&asked, user, sizeof(asked));
  if (result != 0) return result;
  const std::uint32_t line = asked.line_offset;
  if (line >= device().state->line_count) return -EINVAL;
  reap_before_look(line);
  result = start_watch(watcher, line, 1);
  return result != 0 ? result : answer_watch(watcher, line, to_v1(info_of(*device().state, line)), user);
}

int unwatch_line(std::uint32_t watcher, const void* user) {
  std::uint32_t line = 0;
  const int result = sys::copy_in(&line, user, sizeof(line));
  if (result != 0) return result;
  if (line >= device().state->line_count) return -EINVAL;
  if (watcher >= kMaxWatchers) return -EBUSY;
  return (device().state->watchers[watcher].lines.fetch_and(~bit(line)) & bit(line)) != 0 ? 0 : -EBUSY;
}

constexpr std::size_t kEvent = sizeof(gpioevent_data);
constexpr std::size_t kEventV2 = sizeof(gpio_v2_line_event);
constexpr std::size_t kChanged = sizeof(gpioline_info_changed);
constexpr std::size_t kChangedV2 = sizeof(gpio_v2_line_info_changed);
static_assert(kEvent == 16 && kEventV2 == 48 && kChanged == 104 && kChangedV2 == 288);

long whole_events(std::size_t size, std::size_t record) {
  return size < record ? -EINVAL : static_cast<long>(size - size % record);
}

/// The kernel looks at the size only once there is something to read.
long too_small_for_change(int fd) {
  const bool waits = (sys::control(fd, F_GETFL, 0) & O_NONBLOCK) == 0;
  const int ready = sys::readable(fd, waits);
  if (ready < 0) return ready;
  if (!present()) return -ENODEV;
  return ready == 0 ? -EAGAIN : -EINVAL;
}

long whole_changes(int fd, std::uint32_t watcher, std::size_t size) {
  const bool version2 = watcher < kMaxWatchers && device().state->watchers[watcher].version.load() == 2;
  if (size < (version2 ? kChangedV2 : kChanged)) return too_small_for_change(fd);
  if (version2) return static_cast<long>(size - size % kChangedV2);
  // After the first, the kernel wants room for a record of v2 for each of v1.
  const std::size_t more = size < kChanged + kChangedV2 ? 0 : (size - kChangedV2) / kChanged;
  return static_cast<long>((1 + more) * kChanged);
}

}  // namespace

int chip_ioctl(std::uint32_t watcher, unsigned long request, void* argument) {
  if (!present()) return -ENODEV;
  switch (request) {
    case GPIO_GET_CHIPINFO_IOCTL:
      return chip_info(argument);
    case GPIO_GET_LINEINFO_IOCTL:
      return line_info(argument);
    case GPIO_GET_LINEHANDLE_IOCTL:
      return with_request<gpiohandle_request>(argument, request_handle);
    case GPIO_GET_LINEEVENT_IOCTL:
      return with_request<gpioevent_request>(argument, request_event);
    case GPIO_GET_LINEINFO_WATCH_IOCTL:
      return watch_line_v1(watcher, argument);
    case GPIO_GET_LINEINFO_UNWATCH_IOCTL:
      return unwatch_line(watcher, argument);
    case GPIO_V2_GET_LINEINFO_IOCTL:
      return line_info_v2(argument);
    case GPIO_V2_GET_LINEINFO_WATCH_IOCTL:
      return watch_line(watcher, argument);
    case GPIO_V2_GET_LINE_IOCTL:
      return with_request<gpio_v2_line_request>(argument, request_lines);
    default:
      return -EINVAL;
  }
}

int handle_ioctl(std::uint32_t slot, unsigned long request, void* argument) {
  if (!present()) return -ENODEV;
  const Handle& handle = device().state->handles[slot];
  switch (request) {
    case GPIOHANDLE_GET_LINE_VALUES_IOCTL:
      return get_values(handle, argument);
    case GPIOHANDLE_SET_LINE_VALUES_IOCTL:
      return set_values(handle, argument);
    case GPIOHANDLE_SET_CONFIG_IOCTL: {
      gpiohandle_config config{};
      const int copied = sys::copy_in(&config, argument, sizeof(config));
      return copied != 0 ? copied : configure_handle(slot, config);
    }
    default:
      return -EINVAL;
  }
}

int event_ioctl(std::uint32_t line, unsigned long request, void* argument) {
  if (!present()) return -ENODEV;
  if (request != GPIOHANDLE_GET_LINE_VALUES_IOCTL) return -EINVAL;
  if (!plausible(argument)) return -EFAULT;
  gpiohandle_data data{};
  data.values[0] = static_cast<std::uint8_t>(logical_level(*device().state, line));
  memcpy(argument, &data, sizeof(data));
  return 0;
}

int request_ioctl(std::uint32_t slot, unsigned long request, void* argument) {
  if (!present()) return -ENODEV;
  switch (request) {
    case GPIO_V2_LINE_GET_VALUES_IOCTL:
      return get_line_values(slot, argument);
    case GPIO_V2_LINE_SET_VALUES_IOCTL:
      return set_line_values(slot, argument);
    case GPIO_V2_LINE_SET_CONFIG_IOCTL: {
      gpio_v2_line_config config{};
      const int copied = sys::copy_in(&config, argument, sizeof(config));
      return copied != 0 ? copied : configure_lines(slot, config);
    }
    default:
      return -EINVAL;
  }
}

bool is_whole_for_all(std::size_t size) {
  const State* state = device().state;
  if (state == nullptr) return true;
  if (size == 0 || size % kEvent != 0 || state->unplugged.load(std::memory_order_relaxed) != 0) return false;
  const std::uint32_t sizes = state->record_sizes.load(std::memory_order_relaxed);
  if ((sizes & RecordSizes::kEvent) != 0 && size % kEventV2 != 0) return false;
  if ((sizes & RecordSizes::kInfoChanged) != 0 && size % kChangedV2 != 0) return false;
  return (sizes & RecordSizes::kInfoChangedV1) == 0;
}

long whole_records(int fd, std::size_t size) {
  const Descriptor descriptor = describe(fd);
  // Of an unplugged device not even what was queued before.
  if (descriptor.kind != Kind::none && !present()) return -ENODEV;
  switch (descriptor.kind) {
    case Kind::event:
      return whole_events(size, kEvent);
    case Kind::request:
      return whole_events(size, kEventV2);
    case Kind::chip:
      return whole_changes(fd, descriptor.index, size);
    default:
      return static_cast<long>(size);
  }
}

}  // namespace strobe::sim::gpio
