// What a line's information says, in the words of uAPI v2 and v1.
#pragma once

#include <linux/gpio.h>

#include <cstdint>

#include "sim/gpiochip/state.hpp"

namespace strobe::sim::gpio {

gpio_v2_line_info info_of(const State& state, std::uint32_t line);
gpioline_info to_v1(const gpio_v2_line_info& info);

}  // namespace strobe::sim::gpio
