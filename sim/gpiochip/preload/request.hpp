// Requesting lines: GPIO_GET_LINEHANDLE_IOCTL, GPIO_GET_LINEEVENT_IOCTL, and reconfiguring a handle.
#pragma once

#include <linux/gpio.h>

#include <cstdint>

#include "sim/gpiochip/preload/device.hpp"

namespace strobe::sim::gpio {

/// As the kernel's linehandle_create(): lines are taken and driven one after the other; if one fails, those
/// before it are released again, having been driven.
int request_handle(gpiohandle_request& request);
int request_event(gpioevent_request& request);
int configure_handle(std::uint32_t slot, const gpiohandle_config& config);

}  // namespace strobe::sim::gpio
