// Line levels and the ring of their changes: lock-free, and completed by others if a process dies half way.
//
// A change is one compare-and-swap of the line's word, which marks it pending, then one of a ring slot. The
// process that finds a pending line (the next to change it, or a rig that reads it) adds the missing entry to
// the ring, exactly once: the slot is claimed and filled by the same swap, and only if no slot since holds
// that change.
#pragma once

#include <cstdint>

#include "sim/gpiochip/state.hpp"

namespace strobe::sim::gpio {

/// Makes the ring of a new chip empty.
void clear_ring(State& state);

/// Bits of LevelWord that an edit replaces: the pins selected by `mask` become `pins`.
struct PinEdit {
  std::uint64_t mask = 0;
  std::uint64_t pins = 0;
};

constexpr PinEdit drive_edit(unsigned value) {
  return {LevelWord::kDriven | LevelWord::kValue, LevelWord::kDriven | (value != 0 ? LevelWord::kValue : 0)};
}
constexpr PinEdit float_edit() { return {LevelWord::kDriven, 0}; }
constexpr PinEdit outside_edit(unsigned level) {
  return {LevelWord::kOutside | LevelWord::kOpen, level != 0 ? LevelWord::kOutside : 0};
}
constexpr PinEdit open_edit() { return {LevelWord::kOpen, LevelWord::kOpen}; }
/// The resistor that a line's configuration asks for. None asked for: the one that there is stays.
constexpr PinEdit pull_edit(std::uint32_t config) {
  constexpr std::uint64_t kPull = LevelWord::kPulled | LevelWord::kPulledUp;
  if ((config & ConfigWord::kPullUp) != 0) return {kPull, kPull};
  if ((config & ConfigWord::kPullDown) != 0) return {kPull, LevelWord::kPulled};
  if ((config & ConfigWord::kBiasDisable) != 0) return {kPull, 0};
  return {};
}

/// Applies the edit; if the line's level changed by it, that is in the ring when this returns true.
bool change_line(State& state, std::uint32_t line, PinEdit edit, Cause cause, std::int64_t time_ns);

/// Adds changes that a dead process left pending to the ring.
void finish_pending(State& state);

/// Wakes every rig that waits for changes.
void notify(State& state);
/// The same, of one that may be about to sleep.
inline void wake_waiting(State& state) {
  state.waiting.store(1);
  notify(state);
}

unsigned level_of(const State& state, std::uint32_t line);

/// Position after the newest entry.
std::uint64_t newest(State& state);

enum class Slot { ready, not_yet, lapped };
/// The entry at a position. Lapped: it was overwritten.
Slot read_slot(State& state, std::uint64_t position, std::uint64_t& word);

// Debounced inputs, as the kernel debounces in software: a level counts once no edge came for the period that
// the line's v2 request asked for, and its event is stamped then.
//
// Nobody need wake up for that: which level counts follows at any time from the last edge, its time and the
// level that counted before. What must happen in time is only the event; see chip.cpp.

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
