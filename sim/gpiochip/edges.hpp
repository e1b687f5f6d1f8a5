// Edges of inputs, handed by the rig to whoever requested the line for them.
#pragma once

#include <cstdint>

#include "sim/gpiochip/folder.hpp"

namespace strobe::sim::gpio {

/// The line has just become `level` at `stamp_ns`. Nobody else emits an edge of this line meanwhile.
///
/// A v1 request's queue holds 16 events, and a newer one is dropped. A v2 request's drops the oldest, and
/// numbers all its edges, dropped ones too.
///
/// A debounced line only notes the edge.
void emit_edge(const ChipFolder& folder, std::uint32_t line, unsigned level, std::int64_t stamp_ns);

/// Emits the event of a debounced line that has settled at `now_ns` at `level`. Nobody else emits an edge of
/// this line meanwhile.
void emit_settled(const ChipFolder& folder, std::uint32_t line, unsigned level, std::int64_t now_ns);

}  // namespace strobe::sim::gpio
