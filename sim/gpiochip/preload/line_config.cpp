#include "sim/gpiochip/preload/line_config.hpp"

#include <errno.h>

namespace strobe::sim::gpio {
namespace {

constexpr std::uint64_t kDirections = GPIO_V2_LINE_FLAG_INPUT | GPIO_V2_LINE_FLAG_OUTPUT;
constexpr std::uint64_t kEdges = GPIO_V2_LINE_FLAG_EDGE_RISING | GPIO_V2_LINE_FLAG_EDGE_FALLING;
constexpr std::uint64_t kDrives = GPIO_V2_LINE_FLAG_OPEN_DRAIN | GPIO_V2_LINE_FLAG_OPEN_SOURCE;
constexpr std::uint64_t kBiases =
    GPIO_V2_LINE_FLAG_BIAS_PULL_UP | GPIO_V2_LINE_FLAG_BIAS_PULL_DOWN | GPIO_V2_LINE_FLAG_BIAS_DISABLED;
constexpr std::uint64_t kClocks = GPIO_V2_LINE_FLAG_EVENT_CLOCK_REALTIME | GPIO_V2_LINE_FLAG_EVENT_CLOCK_HTE;
constexpr std::uint64_t kKnown =
    GPIO_V2_LINE_FLAG_ACTIVE_LOW | kDirections | kEdges | kDrives | kBiases | kClocks;

bool one_at_most(std::uint64_t flags) { return (flags & (flags - 1)) == 0; }

int check_flags(std::uint64_t flags) {
  if ((flags & ~kKnown) != 0) return -EINVAL;
  // No hardware time stamps, as on kernels built without them.
  if ((flags & GPIO_V2_LINE_FLAG_EVENT_CLOCK_HTE) != 0) return -EOPNOTSUPP;
  const bool input = (flags & GPIO_V2_LINE_FLAG_INPUT) != 0;
  const bool output = (flags & GPIO_V2_LINE_FLAG_OUTPUT) != 0;
  if (input && output) return -EINVAL;
  if ((flags & kEdges) != 0 && !input) return -EINVAL;
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

}  // namespace

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

std::uint64_t flags_of(const gpio_v2_line_config& config, std::uint32_t index) {
  const gpio_v2_line_attribute* found = attribute_of(config, index, GPIO_V2_LINE_ATTR_ID_FLAGS);
  return found != nullptr ? found->flags : config.flags;
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

std::uint32_t debounce_us_of(const gpio_v2_line_config& config, std::uint32_t index) {
  const gpio_v2_line_attribute* found = attribute_of(config, index, GPIO_V2_LINE_ATTR_ID_DEBOUNCE);
  return found != nullptr ? found->debounce_period_us : 0;
}

}  // namespace strobe::sim::gpio
