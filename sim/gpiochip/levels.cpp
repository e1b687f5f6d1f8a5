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

}  // namespace

void clear_ring(State& state) {
  for (std::atomic<std::uint64_t>& slot : state.ring)
    slot.store(RingWord::tag(-std::uint64_t{1}));  // lap before 0
}

bool change_line(State& state, std::uint32_t line, PinEdit edit, CauseCode cause, std::int64_t time_ns) {
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

}  // namespace strobe::sim::gpio
