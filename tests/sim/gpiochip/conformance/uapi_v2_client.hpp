// The kernel's GPIO uAPI v2 by bare system calls, as uapi_client.hpp does v1.
#pragma once

#include <initializer_list>
#include <vector>

#include "tests/sim/gpiochip/conformance/uapi_client.hpp"

namespace uapi::v2 {

constexpr std::uint64_t kIn = GPIO_V2_LINE_FLAG_INPUT;
constexpr std::uint64_t kOut = GPIO_V2_LINE_FLAG_OUTPUT;
constexpr std::uint64_t kLow = GPIO_V2_LINE_FLAG_ACTIVE_LOW;
constexpr std::uint64_t kRising = GPIO_V2_LINE_FLAG_EDGE_RISING;
constexpr std::uint64_t kFalling = GPIO_V2_LINE_FLAG_EDGE_FALLING;
constexpr std::uint64_t kBoth = kRising | kFalling;
constexpr std::uint64_t kDrain = GPIO_V2_LINE_FLAG_OPEN_DRAIN;
constexpr std::uint64_t kSource = GPIO_V2_LINE_FLAG_OPEN_SOURCE;
constexpr std::uint64_t kUp = GPIO_V2_LINE_FLAG_BIAS_PULL_UP;
constexpr std::uint64_t kDown = GPIO_V2_LINE_FLAG_BIAS_PULL_DOWN;
constexpr std::uint64_t kNoBias = GPIO_V2_LINE_FLAG_BIAS_DISABLED;
constexpr std::uint64_t kRealtime = GPIO_V2_LINE_FLAG_EVENT_CLOCK_REALTIME;
constexpr std::uint64_t kHardwareClock = GPIO_V2_LINE_FLAG_EVENT_CLOCK_HTE;

struct Attribute {
  std::uint32_t id = 0;
  std::uint64_t value = 0;
  std::uint64_t mask = 0;
};
constexpr Attribute flags(std::uint64_t value, std::uint64_t mask) {
  return {GPIO_V2_LINE_ATTR_ID_FLAGS, value, mask};
}
constexpr Attribute values(std::uint64_t value, std::uint64_t mask) {
  return {GPIO_V2_LINE_ATTR_ID_OUTPUT_VALUES, value, mask};
}
constexpr Attribute debounce_us(std::uint32_t value, std::uint64_t mask) {
  return {GPIO_V2_LINE_ATTR_ID_DEBOUNCE, value, mask};
}

inline gpio_v2_line_config config(std::uint64_t defaults, std::initializer_list<Attribute> attributes = {}) {
  gpio_v2_line_config config{};
  config.flags = defaults;
  for (const Attribute& attribute : attributes) {
    gpio_v2_line_config_attribute& entry = config.attrs[config.num_attrs++];
    entry.attr.id = attribute.id;
    entry.mask = attribute.mask;
    if (attribute.id == GPIO_V2_LINE_ATTR_ID_DEBOUNCE) {
      entry.attr.debounce_period_us = static_cast<std::uint32_t>(attribute.value);
    } else {
      entry.attr.values = attribute.value;
    }
  }
  return config;
}

inline gpio_v2_line_request request_of(const std::vector<unsigned>& lines, const gpio_v2_line_config& config,
                                       const char* consumer = "client") {
  gpio_v2_line_request request{};
  request.num_lines = static_cast<std::uint32_t>(lines.size());
  for (std::size_t i = 0; i < lines.size() && i < GPIO_V2_LINES_MAX; ++i) request.offsets[i] = lines[i];
  request.config = config;
  memcpy(request.consumer, consumer, strnlen(consumer, sizeof(request.consumer)));
  return request;
}

/// Descriptor of the request, or a negated errno.
inline int take(int chip, gpio_v2_line_request request) {
  const int result = outcome(ioctl(chip, GPIO_V2_GET_LINE_IOCTL, &request));
  return result < 0 ? result : request.fd;
}
inline int take(int chip, const std::vector<unsigned>& lines, const gpio_v2_line_config& config,
                const char* consumer = "client") {
  return take(chip, request_of(lines, config, consumer));
}

inline int set(int request, std::uint64_t bits, std::uint64_t mask) {
  gpio_v2_line_values values{};
  values.bits = bits;
  values.mask = mask;
  return outcome(ioctl(request, GPIO_V2_LINE_SET_VALUES_IOCTL, &values));
}

/// Bits of the lines in `mask`, or a negated errno.
inline int get(int request, std::uint64_t mask) {
  gpio_v2_line_values values{};
  values.bits = ~std::uint64_t{0};
  values.mask = mask;
  const int result = outcome(ioctl(request, GPIO_V2_LINE_GET_VALUES_IOCTL, &values));
  return result < 0 ? result : static_cast<int>(values.bits);
}

inline int configure(int request, gpio_v2_line_config config) {
  return outcome(ioctl(request, GPIO_V2_LINE_SET_CONFIG_IOCTL, &config));
}

inline int info(int chip, unsigned line, gpio_v2_line_info& answer,
                unsigned long request = GPIO_V2_GET_LINEINFO_IOCTL) {
  answer = {};
  answer.offset = line;
  return outcome(ioctl(chip, request, &answer));
}
inline int watch(int chip, unsigned line) {
  gpio_v2_line_info ignored;
  return info(chip, line, ignored, GPIO_V2_GET_LINEINFO_WATCH_IOCTL);
}
inline int unwatch(int chip, unsigned line) {
  return outcome(ioctl(chip, GPIO_GET_LINEINFO_UNWATCH_IOCTL, &line));
}

}  // namespace uapi::v2
