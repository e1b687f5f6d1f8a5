// The kernel's GPIO uAPI v1 by bare system calls, for programs that try a chip, simulated or real. Results
// are 0 or a descriptor, or a negated errno. Plain C++ without libraries: it is also cross-built for a small
// test system.
#pragma once

#include <errno.h>
#include <fcntl.h>
#include <linux/gpio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cstdint>
#include <initializer_list>
#include <vector>

namespace uapi {

inline int outcome(int result) { return result < 0 ? -errno : result; }

inline int open_chip(const char* device, int flags = O_RDWR) {
  return outcome(open(device, flags | O_CLOEXEC));
}

inline gpiohandle_request handle_request(const std::vector<unsigned>& lines, std::uint32_t flags,
                                         const std::vector<unsigned>& values, const char* label) {
  gpiohandle_request request{};
  request.lines = static_cast<std::uint32_t>(lines.size());
  request.flags = flags;
  for (std::size_t i = 0; i < lines.size() && i < GPIOHANDLES_MAX; ++i) request.lineoffsets[i] = lines[i];
  for (std::size_t i = 0; i < values.size() && i < GPIOHANDLES_MAX; ++i)
    request.default_values[i] = static_cast<std::uint8_t>(values[i]);
  strncpy(request.consumer_label, label, sizeof(request.consumer_label) - 1);
  return request;
}

/// Descriptor of the handle, or a negated errno.
inline int request_lines(int chip, const std::vector<unsigned>& lines, std::uint32_t flags,
                         const std::vector<unsigned>& values = {}, const char* label = "client") {
  gpiohandle_request request = handle_request(lines, flags, values, label);
  const int result = outcome(ioctl(chip, GPIO_GET_LINEHANDLE_IOCTL, &request));
  return result < 0 ? result : request.fd;
}

inline int request_event(int chip, unsigned line, std::uint32_t flags, std::uint32_t edges,
                         const char* label = "client") {
  gpioevent_request request{};
  request.lineoffset = line;
  request.handleflags = flags;
  request.eventflags = edges;
  strncpy(request.consumer_label, label, sizeof(request.consumer_label) - 1);
  const int result = outcome(ioctl(chip, GPIO_GET_LINEEVENT_IOCTL, &request));
  return result < 0 ? result : request.fd;
}

inline int set(int handle, std::initializer_list<unsigned> values) {
  gpiohandle_data data{};
  std::size_t i = 0;
  for (const unsigned value : values) data.values[i++] = static_cast<std::uint8_t>(value);
  return outcome(ioctl(handle, GPIOHANDLE_SET_LINE_VALUES_IOCTL, &data));
}

/// Value of one of the handle's lines, or a negated errno.
inline int get(int handle, unsigned index = 0) {
  gpiohandle_data data{};
  const int result = outcome(ioctl(handle, GPIOHANDLE_GET_LINE_VALUES_IOCTL, &data));
  return result < 0 ? result : data.values[index];
}

inline int configure(int handle, std::uint32_t flags, std::initializer_list<unsigned> values = {}) {
  gpiohandle_config config{};
  config.flags = flags;
  std::size_t i = 0;
  for (const unsigned value : values) config.default_values[i++] = static_cast<std::uint8_t>(value);
  return outcome(ioctl(handle, GPIOHANDLE_SET_CONFIG_IOCTL, &config));
}

inline int info(int chip, unsigned line, gpioline_info& answer) {
  answer = {};
  answer.line_offset = line;
  return outcome(ioctl(chip, GPIO_GET_LINEINFO_IOCTL, &answer));
}

}  // namespace uapi
