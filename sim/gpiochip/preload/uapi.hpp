// The kernel's GPIO calls (drivers/gpio/gpiolib-cdev.c) on the simulated chip, by what their descriptor is:
// of the chip, of a line handle or event line (uAPI v1), of a line request (v2). Every function returns what
// the system call would: 0 or a negated errno.
#pragma once

#include "sim/gpiochip/preload/device.hpp"

namespace strobe::sim::gpio {

int chip_ioctl(std::uint32_t watcher, unsigned long request, void* argument);
int handle_ioctl(std::uint32_t slot, unsigned long request, void* argument);
int event_ioctl(std::uint32_t line, unsigned long request, void* argument);
int request_ioctl(std::uint32_t slot, unsigned long request, void* argument);

}  // namespace strobe::sim::gpio
