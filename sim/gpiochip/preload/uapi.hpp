// The kernel's GPIO calls (drivers/gpio/gpiolib-cdev.c) on the simulated chip, by what their descriptor is:
// of the chip, of a line handle or event line (uAPI v1), of a line request (v2). Every function returns what
// the system call would: 0 or a negated errno.
#pragma once

#include <cstddef>
#include <cstdint>

#include "sim/gpiochip/preload/device.hpp"

namespace strobe::sim::gpio {

int chip_ioctl(std::uint32_t watcher, unsigned long request, void* argument);
int handle_ioctl(std::uint32_t slot, unsigned long request, void* argument);
int event_ioctl(std::uint32_t line, unsigned long request, void* argument);
int request_ioctl(std::uint32_t slot, unsigned long request, void* argument);

// Reads of events and of what changed on watched lines: whole records only, as from the kernel.

/// A read of that size can only take whole records, whatever it reads, of a device that is there: nothing to
/// look for.
bool is_whole_for_all(std::size_t size);

/// Bytes that a read of `size` takes at most, or a negated errno.
long whole_records(int fd, std::size_t size);

}  // namespace strobe::sim::gpio
