// Requesting lines by uAPI v2: GPIO_V2_GET_LINE_IOCTL, and reconfiguring what was requested.
#pragma once

#include <linux/gpio.h>

#include <cstdint>

namespace strobe::sim::gpio {

/// As the kernel's linereq_create(): lines are taken and driven one after the other; if one fails, those
/// before it are released again, having been driven.
int request_lines(gpio_v2_line_request& request);
int configure_lines(std::uint32_t slot, const gpio_v2_line_config& config);

}  // namespace strobe::sim::gpio
