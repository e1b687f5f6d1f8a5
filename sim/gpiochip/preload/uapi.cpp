#include "sim/gpiochip/preload/uapi.hpp"

#include <errno.h>
#include <linux/gpio.h>
#include <string.h>

#include "sim/gpiochip/levels.hpp"
#include "sim/gpiochip/line_info.hpp"
#include "sim/gpiochip/preload/lines.hpp"
#include "sim/gpiochip/preload/pins.hpp"
#include "sim/gpiochip/preload/request.hpp"
#include "sim/gpiochip/preload/request_v2.hpp"
#include "sim/gpiochip/preload/uapi_v2.hpp"
#include "sim/gpiochip/rig_time.hpp"
#include "sim/gpiochip/system.hpp"

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
    changed |= change_line(state, line, output_edit(config, values[i]), CauseCode::set, now);
  }
  if (changed) notify(state);
  return 0;
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

}  // namespace strobe::sim::gpio
