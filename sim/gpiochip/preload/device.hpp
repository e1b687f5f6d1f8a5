// The chip as the preloaded library knows it: mapped once at start from STROBE_GPIOCHIP_DIR.
#pragma once

#include <cstddef>
#include <cstdint>

#include "sim/gpiochip/ownership.hpp"
#include "sim/gpiochip/state.hpp"

namespace strobe::sim::gpio {

struct Device {
  State* state = nullptr;  ///< null: variable unset (inert) or wrong (see `wrong`)
  bool wrong = false;      ///< variable set, no usable chip there: every GPIO device node is refused
  char folder[kPathSize] = {};
  char node[64] = {};   ///< /dev/<name>
  char sysfs[96] = {};  ///< /sys/bus/gpio/devices/<name>/dev
};

/// Opened by the first call, which allocates.
const Device& device();
/// For whoever reads a clock: nullptr until the program begins, since an allocator may ask for the time with
/// its lock held.
const Device* mapped_device_or_null();

/// The node exists: mapped and not unplugged.
bool present();

enum class Node {
  other,    ///< not ours: answered natively
  device,   ///< /dev/<name>
  sysfs,    ///< its number under /sys
  missing,  ///< a GPIO device that must not be reached: unplugged, or the variable is wrong
};
Node node_of(const char* path);

enum class Kind { none, chip, handle, event, request };
struct Descriptor {
  Kind kind = Kind::none;
  std::uint32_t index = 0;  ///< chip: watcher; handle, request: slot; event: line
};
/// What a descriptor is, from the descriptor itself: copies by dup, fork or exec are known without a table.
Descriptor describe(int fd);
/// The same, faster for a v2 request.
Descriptor describe_request_first(int fd);

/// Opens the chip: a descriptor that can watch lines as long as there are watchers left.
int open_chip(int flags);

}  // namespace strobe::sim::gpio
