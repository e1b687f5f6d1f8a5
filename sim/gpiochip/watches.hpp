// Watched lines: whoever watches a line is told what happens to it, by records that its open of the chip
// reads.
//
// Every open of the chip is a FIFO of its own, taken from a fixed number of them: by a lock on it, so that
// close() and death free it. Records are written with the chip's lock held by whoever requests, reconfigures
// or releases a line; a release by close() or death is told by whoever finds it (ownership.hpp).
#pragma once

#include <linux/gpio.h>

#include <cstdint>

#include "sim/gpiochip/state.hpp"

namespace strobe::sim::gpio {

/// `change`: GPIO_V2_LINE_CHANGED_REQUESTED, _RELEASED or _CONFIG. Chip's lock held.
void tell_watchers(State& state, const char* folder, std::uint32_t line, std::uint32_t change);

/// By bit; also lines that a process watched which died since.
std::uint64_t watched_lines(const State& state);

// What a line's information says, in the words of uAPI v2 and v1.

gpio_v2_line_info info_of(const State& state, std::uint32_t line);
gpioline_info to_v1(const gpio_v2_line_info& info);

}  // namespace strobe::sim::gpio
