#include "sim/gpiochip/preload/uapi.hpp"

#include <errno.h>
#include <linux/gpio.h>
#include <string.h>

#include "sim/gpiochip/levels.hpp"
#include "sim/gpiochip/preload/pins.hpp"
#include "sim/gpiochip/preload/request.hpp"
#include "sim/gpiochip/system.hpp"

namespace strobe::sim::gpio {
namespace {

/// The two hot calls skip the checked copy, which costs a system call; a wild pointer there is a fault.
bool plausible(const void* user) { return reinterpret_cast<std::uintptr_t>(user) >= 4096; }

int chip_info(void* user) {
  const State& state = *device().state;
  gpiochip_info info{};
  memcpy(info.name, state.name, sizeof(info.name));
  memcpy(info.label, state.label, sizeof(info.label));
  info.lines = state.line_count;
  return sys::copy_out(user, &info, sizeof(info));
}

std::uint32_t info_flags(std::uint32_t config) {
  std::uint32_t flags = 0;
  if ((config & (ConfigWord::kRequested | ConfigWord::kKernelUsed)) != 0) flags |= GPIOLINE_FLAG_KERNEL;
  if ((config & ConfigWord::kIsOut) != 0) flags |= GPIOLINE_FLAG_IS_OUT;
  if ((config & ConfigWord::kActiveLow) != 0) flags |= GPIOLINE_FLAG_ACTIVE_LOW;
  if ((config & ConfigWord::kOpenDrain) != 0) flags |= GPIOLINE_FLAG_OPEN_DRAIN;
  if ((config & ConfigWord::kOpenSource) != 0) flags |= GPIOLINE_FLAG_OPEN_SOURCE;
  if ((config & ConfigWord::kPullUp) != 0) flags |= GPIOLINE_FLAG_BIAS_PULL_UP;
  if ((config & ConfigWord::kPullDown) != 0) flags |= GPIOLINE_FLAG_BIAS_PULL_DOWN;
  if ((config & ConfigWord::kBiasDisable) != 0) flags |= GPIOLINE_FLAG_BIAS_DISABLE;
  return flags;
}

void reap_before_look(State& state, std::uint32_t line) {
  if ((state.lines[line].config.load() & ConfigWord::kRequested) == 0) return;
  const sys::NoSignals quiet;
  const ChipLock lock(device().folder);
  if (lock.error() == 0) reap_line_locked(state, device().folder, lock, line);
}

int line_info(void* user) {
  State& state = *device().state;
  gpioline_info info{};
  const int copied = sys::copy_in(&info, user, sizeof(info));
  if (copied != 0) return copied;
  if (info.line_offset >= state.line_count) return -EINVAL;
  reap_before_look(state, info.line_offset);
  const Line& line = state.lines[info.line_offset];
  info.flags = info_flags(line.config.load());
  memcpy(info.name, line.name, sizeof(info.name));
  get_consumer(line, info.consumer);
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
  const std::int64_t now = sys::now_ns();  // one instant: the lines of a handle change together
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

int chip_ioctl(unsigned long request, void* argument) {
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

}  // namespace strobe::sim::gpio
