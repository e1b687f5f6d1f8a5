#include "sim/gpiochip/debounce.hpp"

#include "sim/gpiochip/levels.hpp"

namespace strobe::sim::gpio {
namespace {

/// The end of the period that the last edge began.
std::int64_t end_of_period_ns(const State& state, std::uint32_t line, std::uint64_t word) {
  const auto edge_ns = static_cast<std::int64_t>(word >> DebounceWord::kTimeShift) + state.epoch_ns;
  return edge_ns + std::int64_t{state.lines[line].debounce_us.load()} * 1'000;
}

}  // namespace

void set_debounce(State& state, std::uint32_t line, std::uint32_t period_us) {
  Line& entry = state.lines[line];
  if (entry.debounce_us.load() == 0) entry.debounce.store(level_of(state, line));
  entry.debounce_us.store(period_us);
}

unsigned debounced_level(const State& state, std::uint32_t line, std::int64_t now_ns) {
  if (!is_debounced(state, line)) return level_of(state, line);
  const std::uint64_t word = state.lines[line].debounce.load();
  const bool settled = (word & DebounceWord::kBouncing) != 0 && now_ns >= end_of_period_ns(state, line, word);
  return settled ? level_of(state, line) : static_cast<unsigned>(word & DebounceWord::kLevel);
}

void note_bounce(State& state, std::uint32_t line, std::int64_t stamp_ns) {
  std::atomic<std::uint64_t>& word = state.lines[line].debounce;
  const std::uint64_t level = word.load() & DebounceWord::kLevel;
  const std::int64_t since_ns = stamp_ns > state.epoch_ns ? stamp_ns - state.epoch_ns : 0;
  word.store(static_cast<std::uint64_t>(since_ns) << DebounceWord::kTimeShift | DebounceWord::kBouncing |
             level);
}

bool take_settled(State& state, std::uint32_t line, unsigned level, std::int64_t now_ns, Settled& settled) {
  std::atomic<std::uint64_t>& word = state.lines[line].debounce;
  const std::uint64_t before = word.load();
  if (!is_debounced(state, line) || (before & DebounceWord::kBouncing) == 0) return false;
  settled.stamp_ns = end_of_period_ns(state, line, before);
  if (now_ns < settled.stamp_ns) return false;
  settled.changed = (before & DebounceWord::kLevel) != level;
  word.store(level);
  return true;
}

}  // namespace strobe::sim::gpio
