#include "sim/gpiochip/levels.hpp"

#include "sim/gpiochip/system.hpp"

namespace strobe::sim::gpio {
namespace {

constexpr std::uint64_t kPayload = ~RingWord::kTagMask;

bool is_in_ring(const State& state, std::uint64_t entry, std::uint64_t from, std::uint64_t to) {
  for (std::uint64_t position = from; position < to; ++position) {
    if ((state.ring[position % kRingSize].load() & kPayload) == entry) return true;
  }
  return false;
}

/// Puts the pending change `word` of a line into the ring unless it is there already, at `from` or later.
void append_once(State& state, std::uint32_t line, std::uint64_t word, std::uint64_t from) {
  const std::uint64_t entry = RingWord::of(word, line);
  for (;;) {
    const std::uint64_t position = state.head.load();
    if (is_in_ring(state, entry, from, position)) return;
    from = position;
    std::atomic<std::uint64_t>& slot = state.ring[position % kRingSize];
    std::uint64_t there = slot.load();
    std::uint64_t expected = position;
    if ((there & RingWord::kTagMask) == RingWord::tag(position)) {
      state.head.compare_exchange_strong(expected, position + 1);
      continue;
    }
    if (state.lines[line].level.load() != word) return;
    if (slot.compare_exchange_strong(there, entry | RingWord::tag(position))) {
      state.head.compare_exchange_strong(expected, position + 1);
      return;
    }
  }
}

void publish(State& state, std::uint32_t line, std::uint64_t word, std::uint64_t from) {
  append_once(state, line, word, from);
  state.lines[line].level.compare_exchange_strong(word, word & ~LevelWord::kPending);
}

/// As publish(), if the time of the change is unknown: the whole ring is searched.
void publish_for_other(State& state, std::uint32_t line, std::uint64_t word) {
  const std::uint64_t head = state.head.load();
  publish(state, line, word, head > kRingSize ? head - kRingSize : 0);
}

std::uint64_t packed_time(const State& state, std::int64_t time_ns) {
  const std::int64_t since = time_ns - state.epoch_ns;
  return static_cast<std::uint64_t>(since > 0 ? since : 0) << LevelWord::kTimeShift;
}

/// The end of the period that the last edge began.
std::int64_t end_of_period_ns(const State& state, std::uint32_t line, std::uint64_t word) {
  const auto edge_ns = static_cast<std::int64_t>(word >> DebounceWord::kTimeShift) + state.epoch_ns;
  return edge_ns + std::int64_t{state.lines[line].debounce_us.load()} * 1'000;
}

}  // namespace

void clear_ring(State& state) {
  for (std::atomic<std::uint64_t>& slot : state.ring)
    slot.store(RingWord::tag(-std::uint64_t{1}));  // lap before 0
}

bool change_line(State& state, std::uint32_t line, PinEdit edit, Cause cause, std::int64_t time_ns) {
  std::atomic<std::uint64_t>& level = state.lines[line].level;
  for (;;) {
    const std::uint64_t from = state.head.load();
    std::uint64_t before = level.load();
    if ((before & LevelWord::kPending) != 0) {
      publish_for_other(state, line, before);
      continue;
    }
    std::uint64_t after = (before & ~edit.mask) | edit.pins;
    if (LevelWord::level(after) == LevelWord::level(before)) {
      if (after == before || level.compare_exchange_strong(before, after)) return false;
      continue;
    }
    after = (after & LevelWord::kPins) | LevelWord::kPending | packed_time(state, time_ns) |
            (static_cast<std::uint64_t>(cause) << LevelWord::kCauseShift);
    if (level.compare_exchange_strong(before, after)) {
      publish(state, line, after, from);
      return true;
    }
  }
}

void finish_pending(State& state) {
  for (std::uint32_t line = 0; line < state.line_count; ++line) {
    const std::uint64_t word = state.lines[line].level.load();
    if ((word & LevelWord::kPending) != 0) publish_for_other(state, line, word);
  }
}

void notify(State& state) {
  state.wake.fetch_add(1);
  if (state.waiting.load() != 0 && state.waiting.exchange(0) != 0) sys::futex_wake_all(&state.wake);
}

unsigned level_of(const State& state, std::uint32_t line) {
  return LevelWord::level(state.lines[line].level.load());
}

std::uint64_t newest(State& state) {
  for (;;) {
    std::uint64_t position = state.head.load();
    const std::uint64_t word = state.ring[position % kRingSize].load();
    if ((word & RingWord::kTagMask) != RingWord::tag(position)) {
      if (state.head.load() == position) return position;
      continue;
    }
    state.head.compare_exchange_strong(position, position + 1);
  }
}

Slot read_slot(State& state, std::uint64_t position, std::uint64_t& word) {
  if (position >= newest(state)) return Slot::not_yet;
  word = state.ring[position % kRingSize].load();
  const bool same_lap = (word & RingWord::kTagMask) == RingWord::tag(position);
  return same_lap && state.head.load() - position <= kRingSize ? Slot::ready : Slot::lapped;
}

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
