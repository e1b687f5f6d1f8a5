// A train by the two players: loaded, begun, watched to its end.
#include <algorithm>
#include <cmath>

#include "firmware/rp1_pio/rp1_hardware.hpp"
#include "firmware/rp1_pio/rp1_program.hpp"

namespace strobe::firmware {

using namespace rp1_program;
using flash_sequencer::kNoTicks;
using flash_sequencer::kTick_ns;
using flash_sequencer::Progress;
using flash_sequencer::Ticks;
namespace pio = flash_sequencer::pio;

namespace {

// The players start so long before the train's begin: that of a START that comes late, and that of others,
// with time to try again.
constexpr Duration kShortLead = microseconds(300), kLongLead = milliseconds(40);
constexpr Duration kMinLead = microseconds(50);
/// Their start is spun for so long.
constexpr Duration kSpinFor = microseconds(300);
/// Their start is known to lie in so short a time, or it is tried again; after kTries in kLongestCall.
constexpr Duration kShortCall = microseconds(20), kLongestCall = microseconds(100);
constexpr int kTries = 4;

/// The train's end is looked for so long after its instant, then again and again.
constexpr Duration kEndAfter = microseconds(30), kEndEvery = microseconds(200);
/// Its machine's words are looked for so often; if there are none for so many times they do not come.
constexpr Duration kQueueEvery = microseconds(400);
constexpr int kMaxEmptyLooks = 2;
/// A count is no further from the truth than its bracket, but for so much.
constexpr Duration kCountWithin = microseconds(2);
/// NTP has CLOCK_MONOTONIC run faster or slower for a while, by so much in a bad case.
constexpr double kSlewing = 100e-6;
/// The kernel stamps an edge later than it was.
constexpr Duration kStampLate = milliseconds(5);

Duration length_of(Ticks ticks) { return Duration{ticks * kTick_ns}; }
MonoTime instant_of(Ticks ticks) { return from_ns(ticks * kTick_ns); }
Ticks ticks_at(MonoTime time) { return known(time) ? to_ns(time) / kTick_ns : kNoTicks; }

/// Of a delay: what X has room for, less the longest lead.
constexpr std::int64_t kMaxCycles = 0xffff'ffff - kLongLead / nanoseconds(PioBlock::kCycle_ns) * 2;

constexpr unsigned machine_of(std::size_t index) { return static_cast<unsigned>(index); }

}  // namespace

// ---- loading ----

void Rp1Hardware::prepare(std::span<Edge> movers, std::span<Edge> lamps) {
  forget_train();
  progress_ = {};
  train_ = !movers.empty() || !lamps.empty();
  drift_sd_ = drift_sd(clock_.now());
  const bool loaded = block_.disable(1U << kMovers | 1U << kLamps) && load(kMovers, movers) &&
                      load(kLamps, lamps) && aim(kShortLead);
  if (!loaded) fail_train();
}

void Rp1Hardware::forget_train() noexcept {
  for (Track& track : tracks_) {
    track.edges = {};
    track.over = true;
  }
  train_ = waits_ = gated_ = gate_wanted_ = false;
  gate_ = Gate::closed;
  gate_stamp_ = gate_heard_ = begin_ = burst_begin_ = kNoTime;
  lead_.reset();
  tries_ = 0;
  counts_ = false;
}

/// Each edge is rounded by itself, so that their errors do not add up.
bool Rp1Hardware::load(std::size_t index, std::span<const Edge> edges) noexcept {
  Track& track = tracks_[index];
  track.edges = edges;
  track.ended = false;
  track.looked_at = track.queue_looked_at = {};
  track.empty_looks = 0;
  track.over = track.empty();
  track.played = 0;
  track.length = {};
  if (track.empty()) return true;
  track.next = length_of(edges[0].delay);
  std::size_t count = 0;
  std::int64_t before = 0;
  for (const Edge& edge : edges) {
    track.length += length_of(edge.delay);
    const std::int64_t at = cycles_in(track.length);
    if (at - before > kMaxCycles) return false;
    if (count == 0)
      track.first_cycles = at;
    else
      track.words[count++] = static_cast<std::uint32_t>(at - before - flash_sequencer::kEdgeCycles);
    track.words[count++] = word_of(edge.levels, index);
    before = at;
  }
  const unsigned machine = machine_of(index);
  return flush(machine) && set_up_player(index, kPlay) &&
         block_.transfer(machine, std::span(track.words).first(count)) &&
         set_register(machine, pio::To::y, static_cast<std::uint32_t>(edges.size() - 1));
}

/// What is left of an earlier train's words goes nowhere: the machine takes them all, and does nothing else.
bool Rp1Hardware::flush(unsigned machine) noexcept {
  if (!block_.transferring(machine)) return true;
  const PioBlock::Registers registers{.execctrl = pio::wrap(kNextEdge, kNextEdge),
                                      .shiftctrl = pio::kShiftOutRight | pio::kAutopull};
  if (!block_.set_up(machine, registers, kNextEdge) || !block_.enable(1U << machine)) return false;
  constexpr int kLooks = 500;
  int looks = 0;
  while (block_.transferring(machine) && looks < kLooks) ++looks;
  return looks < kLooks && block_.disable(1U << machine);
}

std::uint32_t Rp1Hardware::word_of(std::uint32_t levels, std::size_t index) const noexcept {
  std::uint32_t word = 0;
  for (std::size_t line = 0; line < pins_.outputs.size(); ++line) {
    if ((levels >> line & 1U) == 0 || pins_.outputs[line] == Rp1Pins::kNotFitted) continue;
    word |= 1U << (pins_.outputs[line] - track_pins_[index].first);
  }
  return word;
}

std::int64_t Rp1Hardware::cycles_in(Duration duration) const noexcept {
  constexpr auto kCycle_ns = static_cast<double>(PioBlock::kCycle_ns);
  return std::llround(static_cast<double>(duration.count()) / (kCycle_ns * (1.0 + drift_)));
}

// ---- the begin ----

void Rp1Hardware::start(Ticks at, bool gated) {
  start_at_ = instant_of(at);
  gated_ = gated;
  waits_ = true;
  if (longest_lead() > milliseconds(2)) (void)aim(longest_lead());
}

/// Has the players wait from their start on for so long, and then for their first edges.
bool Rp1Hardware::aim(Duration lead) noexcept {
  const MonoTime before = clock_.now();
  lead_.reset();
  bool done = true;
  for (const unsigned machine : {kMovers, kLamps}) {
    const Track& track = tracks_[machine];
    if (track.empty() || (machine == kLamps && gated_)) continue;
    const std::int64_t cycles = cycles_in(lead) + track.first_cycles - kFirstCycles;
    done = done && set_register(machine, pio::To::x, static_cast<std::uint32_t>(cycles)) &&
           block_.execute(machine, pio::jmp(kPlay));
  }
  aim_took_ = clock_.now() - before;
  if (done) lead_ = lead;
  return done;
}

/// That there is time to aim at.
Duration Rp1Hardware::longest_lead() noexcept {
  return std::min(kLongLead, start_at_ - clock_.now() - 2 * aim_took_ - kSpinFor);
}

MonoTime Rp1Hardware::begin_due() const noexcept {
  if (!waits_) return MonoTime::max();
  return lead_ ? start_at_ - *lead_ - kSpinFor : MonoTime{};
}

void Rp1Hardware::begin() noexcept {
  const Duration left = start_at_ - clock_.now();
  if (lead_ && left >= *lead_) {
    if (left <= *lead_ + kSpinFor) enable_players(start_at_ - *lead_);
    return;
  }
  if (longest_lead() >= kMinLead) {
    (void)aim(longest_lead());
    return;
  }
  waits_ = false;
  fail_train();
}

/// Both in the same cycle. What stalled here, and for how long, is not known: it is tried again.
void Rp1Hardware::enable_players(MonoTime planned) noexcept {
  unsigned players = tracks_[kMovers].empty() ? 0 : 1U << kMovers;
  if (!gated_ && !tracks_[kLamps].empty()) players |= 1U << kLamps;
  if (players == 0) return begun(planned, planned);
  clock_.spin_until(planned - half_call_);
  const MonoTime before = clock_.now();
  const bool enabled = block_.enable(players);
  const MonoTime after = clock_.now();
  const Duration bracket = after - before;
  const bool time_left = start_at_ - after > 4 * aim_took_ + 2 * kSpinFor;
  const Duration longest = time_left && ++tries_ < kTries ? kShortCall : kLongestCall;
  if (enabled && bracket <= longest && after - planned <= kLongestCall) return begun(before, after);

  lead_.reset();
  if (block_.disable(players)) return;
  waits_ = false;
  fail_train();
}

void Rp1Hardware::begun(MonoTime not_before, MonoTime not_after) noexcept {
  waits_ = false;
  half_call_ = (not_after - not_before) / 2;
  begin_ = not_before + half_call_ + *lead_;
  const Duration by_drift = from_seconds(3.0 * drift_sd_ * to_seconds(*lead_));
  start_within_ns_ = (half_call_ + by_drift).count();
  if (!gated_) {
    burst_begin_ = begin_;
    return;
  }
  if (tracks_[kLamps].empty()) return;
  const std::int64_t cycles = tracks_[kLamps].first_cycles - kGateCycles;
  const bool done = set_register(kLamps, pio::To::x, static_cast<std::uint32_t>(cycles)) &&
                    block_.execute(kLamps, pio::jmp(kPlayGated));
  if (!done) fail_train();
}

// ---- the gate ----

void Rp1Hardware::listen_to_gate(bool listens) {
  gate_wanted_ = listens;
  if (train_ && known(begin_)) keep_gate();
}

void Rp1Hardware::keep_gate() noexcept {
  if (!gated_ || tracks_[kLamps].over) return;
  if (gate_wanted_ && gate_ == Gate::closed) open_gate();
  if (gate_ != Gate::closed && !known(burst_begin_)) hear_gate();
  if (!gate_wanted_ && gate_ == Gate::open) close_gate();
}

void Rp1Hardware::open_gate() noexcept {
  gate_ = Gate::open;
  gate_opened_ = clock_.now();
  if (!block_.enable(1U << kLamps)) fail_train();
}

/// The machine pushes a word at the gate's edge; which edge it was, the kernel's stamp of it tells.
void Rp1Hardware::hear_gate() noexcept {
  const MonoTime now = clock_.now();
  if (gate_ == Gate::open && block_.get(kLamps)) {
    gate_ = Gate::heard;
    gate_heard_ = now;
  }
  if (gate_ == Gate::open) {
    gate_stamp_ = kNoTime;  // of an edge that came too early, as may be those that are not taken yet
    gate_opened_ = now;
  } else if (known(gate_stamp_)) {
    burst_begin_ = gate_stamp_;
  } else if (now - gate_heard_ > kStampLate) {
    fail_train();  // when it began is not known
  }
}

/// For good. An edge in between does not count.
void Rp1Hardware::close_gate() noexcept {
  gate_ = Gate::closed;
  const bool done =
      block_.disable(1U << kLamps) && block_.execute(kLamps, pio::mov(pio::To::pins, pio::From::null));
  if (!done) fail_train();
  tracks_[kLamps].edges = {};
  tracks_[kLamps].over = true;
}

// ---- the end ----

MonoTime Rp1Hardware::begin_of(std::size_t index) const noexcept {
  return index == kLamps ? burst_begin_ : begin_;
}

MonoTime Rp1Hardware::end_due(std::size_t index) const noexcept {
  const Track& track = tracks_[index];
  const MonoTime begin = begin_of(index);
  if (track.over || !known(begin)) return MonoTime::max();
  return std::max(begin + track.length + kEndAfter, track.looked_at + kEndEvery);
}

void Rp1Hardware::watch_train() noexcept {
  if (waits_) begin();
  if (!known(begin_)) return;
  keep_gate();
  for (std::size_t index = 0; index < kTrackCount; ++index) {
    watch_queue(index);
    if (clock_.now() >= end_due(index)) watch_end(index);
  }
  train_ = !(tracks_[kMovers].over && tracks_[kLamps].over);
}

/// A machine whose words do not come stands still, with its outputs as they are.
void Rp1Hardware::watch_queue(std::size_t index) noexcept {
  Track& track = tracks_[index];
  // Of edges so near to the end the words are out of the queue, or their time has come unseen.
  constexpr std::size_t kLast = 3;
  const MonoTime now = clock_.now();
  if (track.over || !known(begin_of(index)) || now < track.queue_looked_at + kQueueEvery) return;
  if (track.edges.size() - played(index) <= kLast) return;
  track.queue_looked_at = now;
  const auto queued = block_.queued(machine_of(index));
  if (queued && *queued != 0) track.empty_looks = 0;
  if (queued && *queued == 0 && ++track.empty_looks == kMaxEmptyLooks) fail_train();
}

/// A track that is over at another instant than it should be was not fed in time.
void Rp1Hardware::watch_end(std::size_t index) noexcept {
  Track& track = tracks_[index];
  const MonoTime expected = begin_of(index) + track.length;
  const bool by_gate = index == kLamps && gated_;
  const Duration by_drift = from_seconds((kSlewing + 4.0 * drift_sd_) * to_seconds(track.length));
  const Duration late = by_drift + kCountWithin + (by_gate ? Duration{} : Duration{start_within_ns_});
  if (!track.ended) track.ended = block_.get(machine_of(index)).has_value();
  track.looked_at = clock_.now();
  if (!track.ended) {
    if (track.looked_at > expected + late + milliseconds(1)) fail_train();
    return;
  }
  const auto count = count_of(machine_of(index));
  if (!count) return fail_train();
  const double cycle_ns = static_cast<double>(PioBlock::kCycle_ns) * (1.0 + drift_);
  const Duration ago{std::llround(cycle_ns * static_cast<double>(count->cycles + kOverCycles))};
  const Duration early = late + (by_gate ? kStampLate : Duration{});
  if (count->not_before - ago > expected + late || count->not_after - ago < expected - early) fail_train();
  track.over = true;
}

Progress Rp1Hardware::progress() {
  if (cut_) return progress_;
  progress_.started = ticks_at(begin_);
  progress_.burst_started = ticks_at(burst_begin_);
  for (std::size_t index = 0; index < kTrackCount; ++index) {
    progress_.played[index] = static_cast<std::uint16_t>(played(index));
  }
  return progress_;
}

/// By time; the last one when the machine has said that it is over.
std::size_t Rp1Hardware::played(std::size_t index) noexcept {
  Track& track = tracks_[index];
  if (track.empty() || track.over || !known(begin_of(index))) return track.over ? track.edges.size() : 0;
  const Duration surely = clock_.now() - begin_of(index) - Duration{start_within_ns_};
  while (track.played + 1 < track.edges.size() && track.next <= surely)
    track.next += length_of(track.edges[++track.played].delay);
  return track.played;
}

std::uint8_t Rp1Hardware::planned_levels() {
  std::uint32_t levels = 0;
  for (std::size_t index = 0; index < kTrackCount; ++index) {
    const std::size_t count = played(index);
    if (count != 0) levels |= tracks_[index].edges[count - 1].levels;
  }
  return static_cast<std::uint8_t>(levels);
}

}  // namespace strobe::firmware
