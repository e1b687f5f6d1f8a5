// What a v2 line configuration asks of each of its lines: defaults and attributes with line masks.
#pragma once

#include <linux/gpio.h>

#include <cstdint>

#include "sim/gpiochip/preload/lines.hpp"

namespace strobe::sim::gpio {

/// As the kernel's gpio_v2_line_config_validate(): 0 or a negated errno.
int check_config(const gpio_v2_line_config& config, std::uint32_t lines);

/// `index`: of the line in its request.
std::uint64_t flags_of(const gpio_v2_line_config& config, std::uint32_t index);
LineSetting setting_of(const gpio_v2_line_config& config, std::uint32_t index);
std::uint32_t debounce_us_of(const gpio_v2_line_config& config, std::uint32_t index);  ///< 0: none

}  // namespace strobe::sim::gpio
