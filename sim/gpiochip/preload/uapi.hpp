// The kernel's GPIO uAPI v1 (drivers/gpio/gpiolib-cdev.c) on the simulated chip. Every function returns what
// the system call would: 0 or a negated errno. uAPI v2 and line-info watches are answered EINVAL, as by a
// kernel from before they existed: libgpiod 1.6 uses neither.
#pragma once

#include "sim/gpiochip/preload/device.hpp"

namespace strobe::sim::gpio {

int chip_ioctl(unsigned long request, void* argument);
int handle_ioctl(std::uint32_t slot, unsigned long request, void* argument);
int event_ioctl(std::uint32_t line, unsigned long request, void* argument);

}  // namespace strobe::sim::gpio
