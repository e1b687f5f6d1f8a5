// Requesting lines, and reconfiguring what was requested: GPIO_GET_LINEHANDLE_IOCTL and
// GPIO_GET_LINEEVENT_IOCTL of uAPI v1, GPIO_V2_GET_LINE_IOCTL of v2. Each returns 0 or a negated errno.
#pragma once

#include <linux/gpio.h>

#include <cstdint>

namespace strobe::sim::gpio {

/// As the kernel's linehandle_create(): lines are taken and driven one after the other; if one fails, those
/// before it are released again, having been driven.
int request_handle(gpiohandle_request& request);
int request_event(gpioevent_request& request);
int configure_handle(std::uint32_t slot, const gpiohandle_config& config);

/// As the kernel's linereq_create(): likewise.
int request_lines(gpio_v2_line_request& request);
int configure_lines(std::uint32_t slot, const gpio_v2_line_config& config);

}  // namespace strobe::sim::gpio
