// Debounced inputs, as the kernel debounces in software: a level counts once no edge came for the period that
// the line's v2 request asked for, and its event is stamped then.
//
// Nobody need wake up for that: which level counts follows at any time from the last edge, its time and the
// level that counted before. What must happen in time is only the event; see edges.hpp.
#pragma once

#include <cstdint>

#include "sim/gpiochip/state.hpp"

namespace strobe::sim::gpio {

inline bool is_debounced(const State& state, std::uint32_t line) {
  return state.lines[line].debounce_us.load() != 0;
}
inline bool any_debounced(const State& state) {
  for (std::uint32_t line = 0; line < state.line_count; ++line)
    if (is_debounced(state, line)) return true;
  return false;
}

/// A new period, 0 for none. A line that was not debounced starts with its level now.
void set_debounce(State& state, std::uint32_t line, std::uint32_t period_us);

/// The level that counts at that time; the pin's own if it is not debounced.
unsigned debounced_level(const State& state, std::uint32_t line, std::int64_t now_ns);

/// An edge at that time begins the period anew. What had settled before must have been taken.
void note_bounce(State& state, std::uint32_t line, std::int64_t stamp_ns);

/// True if no edge came for a period at `now_ns`: the line's pin had `level` all the while. Once for each
/// time that it settles.
struct Settled {
  bool changed = false;       ///< to another level than the one that counted before
  std::int64_t stamp_ns = 0;  ///< the end of the period
};
bool take_settled(State& state, std::uint32_t line, unsigned level, std::int64_t now_ns, Settled& settled);

}  // namespace strobe::sim::gpio
