// From a logical value to what the chip does to the pin.
#pragma once

#include <cstdint>

#include "sim/gpiochip/levels.hpp"

namespace strobe::sim::gpio {

constexpr unsigned physical(std::uint32_t config, unsigned logical) {
  return (logical != 0) != ((config & ConfigWord::kActiveLow) != 0) ? 1 : 0;
}

/// Open drain and open source are emulated as the kernel does it: the undriven level is "not driven".
constexpr PinEdit output_edit(std::uint32_t config, unsigned logical) {
  const unsigned value = physical(config, logical);
  if ((config & ConfigWord::kOpenDrain) != 0 && value == 1) return float_edit();
  if ((config & ConfigWord::kOpenSource) != 0 && value == 0) return float_edit();
  return drive_edit(value);
}

}  // namespace strobe::sim::gpio
