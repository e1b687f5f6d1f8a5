#include "firmware/rp1_pio/rp1_hardware.hpp"

#include <algorithm>

#include "firmware/flash_sequencer/input_lines.hpp"
#include "firmware/rp1_pio/rp1_program.hpp"

namespace strobe::firmware {

using namespace rp1_program;
using flash_sequencer::CutCause;
using flash_sequencer::InputEdge;
using flash_sequencer::InputLine;
using flash_sequencer::kOutputCount;
using flash_sequencer::kTick_ns;
using flash_sequencer::Ticks;
namespace pio = flash_sequencer::pio;

namespace {

constexpr std::array kWatchers = {kEstopWatch, kKeyWatch};
constexpr unsigned kPlayers = 1U << kMovers | 1U << kLamps;

/// Without being fed for so long the watchers write zeros: of a thread that died within 20 ms, and one that
/// stalls for 15 ms loses nothing.
constexpr Duration kWatchTimeout = milliseconds(18);
constexpr Duration kFeedEvery = milliseconds(2);

constexpr Duration kCountEvery = milliseconds(40);
/// Counts over less than that tell a drift that may be further off than they say.
constexpr Duration kSettled = milliseconds(1500);
/// In which a machine that is asked for its count does not count.
constexpr std::uint32_t kAskingCycles = 2;
/// Of the drift since it was measured, in a second: crystals warm, and NTP steers the clock.
constexpr double kDriftAges = 0.02e-6;

Rp1PinSpan span_of(std::span<const unsigned> pins) {
  unsigned first = Rp1Pins::kNotFitted, last = 0;
  for (const unsigned pin : pins) {
    if (pin == Rp1Pins::kNotFitted) continue;
    first = std::min(first, pin);
    last = std::max(last, pin);
  }
  return first == Rp1Pins::kNotFitted ? Rp1PinSpan{} : Rp1PinSpan{first, last - first + 1};
}

}  // namespace

bool cut_outputs(PioBlock& block) noexcept {
  bool done = true;
  for (const unsigned watcher : kWatchers) done = block.execute(watcher, pio::jmp(kHeld)) && done;
  return done;
}

Rp1Hardware::Rp1Hardware(PioBlock& block, EdgeSource& edges, Clock& clock, const Rp1Pins& pins,
                         std::uint64_t seed)
    : block_(block),
      edges_(edges),
      clock_(clock),
      pins_(pins),
      all_pins_(span_of(pins.outputs)),
      random_(seed) {
  constexpr std::size_t kMoverCount = 2;
  track_pins_ = {span_of(std::span(pins_.outputs).first<kMoverCount>()),
                 span_of(std::span(pins_.outputs).subspan<kMoverCount>())};
}

// ---- the block ----

bool Rp1Hardware::take() noexcept {
  const auto program = code(pins_.gate == Rp1Pins::kNotFitted ? 0 : pins_.gate, pins_.gate_active_low);
  return block_.disable(kPlayers | 1U << kEstopWatch | 1U << kKeyWatch) && block_.load(program) &&
         set_up_watcher(kEstopWatch, pins_.estop) && set_up_watcher(kKeyWatch, pins_.key) && drive_outputs();
}

bool Rp1Hardware::set_up_watcher(unsigned machine, unsigned pin) noexcept {
  const PioBlock::Registers registers{.execctrl = pio::wrap(kHeld, kHeld) | pio::jump_pin(pin),
                                      .shiftctrl = pio::kShiftOutRight,
                                      .pinctrl = pio::out_pins(all_pins_.first, all_pins_.count)};
  constexpr auto kCounts =
      static_cast<std::uint32_t>(kWatchTimeout.count() / (PioBlock::kCycle_ns * kCyclesPerCount));
  return block_.set_up(machine, registers, kHeld) && set_register(machine, pio::To::y, kCounts);
}

/// Zero before they are outputs, outputs before they are given to the block.
bool Rp1Hardware::drive_outputs() noexcept {
  bool done = block_.execute(kKeyWatch, pio::mov(pio::To::pins, pio::From::null)) &&
              block_.execute(kKeyWatch, pio::mov(pio::To::osr, pio::From::null, true)) &&
              block_.execute(kKeyWatch, pio::out_all(pio::To::pindirs)) &&
              block_.enable(1U << kEstopWatch | 1U << kKeyWatch);
  for (const unsigned pin : pins_.outputs) {
    if (pin != Rp1Pins::kNotFitted) done = done && block_.drive(pin);
  }
  return done;
}

/// By way of X and ISR.
bool Rp1Hardware::set_register(unsigned machine, pio::To to, std::uint32_t value) noexcept {
  constexpr unsigned kBits = 5;
  unsigned shift = 0;
  while (shift + kBits < 32 && value >> (shift + kBits) != 0) shift += kBits;
  bool done = block_.execute(machine, pio::mov(pio::To::isr, pio::From::null));
  for (bool more = true; more && done; shift -= kBits) {
    done = block_.execute(machine, pio::set(pio::To::x, value >> shift & ((1U << kBits) - 1))) &&
           block_.execute(machine, pio::in_x(kBits));
    more = shift != 0;
  }
  return done && block_.execute(machine, pio::mov(to, pio::From::isr));
}

bool Rp1Hardware::set_up_player(std::size_t index, unsigned address) noexcept {
  const Rp1PinSpan& pins = track_pins_[index];
  return block_.set_up(static_cast<unsigned>(index),
                       {.execctrl = pio::wrap(0, PioBlock::kInstructionCount - 1),
                        .shiftctrl = pio::kShiftOutRight | pio::kAutopull,
                        .pinctrl = pio::out_pins(pins.first, pins.count)},
                       address);
}

/// Of a machine that counts X down from all ones.
std::optional<Rp1Hardware::Count> Rp1Hardware::count_of(unsigned machine) noexcept {
  Count count;
  count.not_before = clock_.now();
  if (!block_.execute(machine, pio::mov(pio::To::isr, pio::From::x))) return std::nullopt;
  count.not_after = clock_.now();
  if (!block_.execute(machine, pio::push_noblock())) return std::nullopt;
  const auto word = block_.get(machine);
  if (!word) return std::nullopt;
  count.cycles = ~*word;
  return count;
}

// ---- turns ----

MonoTime Rp1Hardware::due() const noexcept {
  MonoTime next = cut_ && cut_obeyed_ ? MonoTime::max() : feed_at_;
  if (!train_) return std::min(next, count_at_);
  next = std::min(next, begin_due());
  for (std::size_t index = 0; index < kTrackCount; ++index) next = std::min(next, end_due(index));
  return next;
}

void Rp1Hardware::poll(MonoTime until) noexcept {
  take_edges(std::min(until, due()));
  if (train_) watch_train();  // first: its begin is at an instant
  feed_watchers();
  if (!train_) count_on();
}

void Rp1Hardware::take_edges(MonoTime until) noexcept {
  std::array<firmware::Edge, 32> edges;
  const auto count = edges_.wait(until, edges);
  for (const firmware::Edge& edge : std::span(edges).first(count.value_or(0))) {
    if (edge.input == Input::gate && gate_ != Gate::closed && edge.time >= gate_opened_ &&
        !known(gate_stamp_))
      gate_stamp_ = edge.time;
    if (end_input_ - first_input_ == inputs_.size()) {
      ++lost_inputs_;
      continue;
    }
    inputs_[end_input_++ % inputs_.size()] = {.line = input_line_of(edge.input),
                                              .active = static_cast<std::uint8_t>(edge.active ? 1 : 0),
                                              .time = to_ns(edge.time) / kTick_ns};
  }
}

/// Those that were not fed in time have cut: whether they say so or not.
void Rp1Hardware::feed_watchers() noexcept {
  const MonoTime now = clock_.now();
  if (now < feed_at_) return;
  feed_at_ = now + kFeedEvery;
  if (cut_) {
    if (!cut_obeyed_) cut();
    return;
  }
  if (now - fed_ > kWatchTimeout) note_cut(CutCause::heartbeat);
  bool fed = true;
  for (const unsigned watcher : kWatchers) {
    fed = block_.execute(watcher, pio::mov(pio::To::x, pio::From::y)) && fed;
    if (!block_.get(watcher)) continue;
    const bool starved = clock_.now() - fed_ > kWatchTimeout;  // within these calls, that is
    note_cut(starved ? CutCause::heartbeat : (watcher == kEstopWatch ? CutCause::estop : CutCause::key));
  }
  if (fed) fed_ = now;
}

void Rp1Hardware::note_cut(CutCause cause) noexcept {
  if (cut_by_itself_ == CutCause::none) cut_by_itself_ = cause;
}

// ---- what cuts ----

void Rp1Hardware::cut() {
  cut_obeyed_ = cut_outputs(block_);
  cut_obeyed_ = block_.disable(kPlayers) && cut_obeyed_;
  if (!cut_) (void)progress();  // as it is now
  cut_ = true;
  forget_train();
}

bool Rp1Hardware::release() {
  if ((inputs() & (bit(InputLine::key) | bit(InputLine::estop))) != bit(InputLine::key)) return false;
  if (!cut_obeyed_) cut();
  if (!cut_obeyed_) return false;
  bool done = true;
  for (const unsigned watcher : kWatchers) {
    drain(watcher);
    done = block_.execute(watcher, pio::mov(pio::To::x, pio::From::y)) &&
           block_.execute(watcher, pio::jmp(kWatch)) && done;
  }
  fed_ = clock_.now();
  if (!done) {
    cut_obeyed_ = cut_outputs(block_);
    return false;
  }
  cut_ = false;
  cut_by_itself_ = CutCause::none;
  progress_ = {};
  return true;
}

void Rp1Hardware::drain(unsigned machine) noexcept {
  constexpr int kQueued = 8;
  for (int i = 0; i < kQueued && block_.get(machine); ++i) {
  }
}

CutCause Rp1Hardware::cut_by_itself() {
  if (!cut_) return cut_by_itself_;
  const std::uint8_t levels = inputs();
  if ((levels & bit(InputLine::estop)) != 0) return CutCause::estop;
  return (levels & bit(InputLine::key)) == 0 ? CutCause::key : CutCause::none;
}

// ---- levels and edges ----

Ticks Rp1Hardware::now() { return to_ns(clock_.now()) / kTick_ns; }

/// Key or e-stop that cannot be read forbid.
std::uint8_t Rp1Hardware::inputs() {
  std::uint8_t levels = 0;
  for (const SequencerInput& each : kSequencerInputs) {
    if (edges_.level(each.input).value_or(each.input == Input::estop))
      levels |= bit(input_line_of(each.input));
  }
  return levels;
}

/// While a train may play as it is planned: to look at the pins would take cycles from the watchers. Those
/// that cannot be read may be high.
std::uint8_t Rp1Hardware::outputs() {
  if (!cut_) return planned_levels();
  drain(kEstopWatch);
  const bool asked = block_.execute(kEstopWatch, pio::mov(pio::To::isr, pio::From::pins)) &&
                     block_.execute(kEstopWatch, pio::push_noblock());
  const std::uint32_t pins = (asked ? block_.get(kEstopWatch) : std::nullopt).value_or(~0U);
  std::uint8_t levels = 0;
  for (std::size_t line = 0; line < kOutputCount; ++line) {
    const unsigned pin = pins_.outputs[line];
    if (pin != Rp1Pins::kNotFitted && (pins >> pin & 1U) != 0)
      levels |= static_cast<std::uint8_t>(1U << line);
  }
  return levels;
}

bool Rp1Hardware::pop_input(InputEdge& edge) {
  if (first_input_ == end_input_) return false;
  edge = inputs_[first_input_++ % inputs_.size()];
  return true;
}

std::uint16_t Rp1Hardware::lost_inputs() {
  return static_cast<std::uint16_t>(lost_inputs_ + edges_.kernel_overflows());
}

// ---- clocks ----

/// Between trains a player counts cycles.
void Rp1Hardware::count_on() noexcept {
  const MonoTime now = clock_.now();
  if (now < count_at_) return;
  count_at_ = now + kCountEvery;
  drift_sd_ = drift_sd(now);
  if (!counts_) {
    counts_ = begin_count();
    return;
  }
  const auto count = count_of(kLamps);
  counts_ = count.has_value();  // else begun anew, with empty queues
  if (!counts_) return;
  counted_cycles_ += count->cycles - last_count_ + kAskingCycles;
  last_count_ = count->cycles;
  relation_.observe(count->not_before, counted_cycles_ * PioBlock::kCycle_ns / kTick_ns, count->not_after);
  if (counted_cycles_ < kSettled / nanoseconds(PioBlock::kCycle_ns) || relation_.drift_sd() > drift_sd_)
    return;
  drift_ = relation_.drift();
  drift_sd_ = kept_drift_sd_ = relation_.drift_sd();
  drift_known_at_ = now;
}

bool Rp1Hardware::begin_count() noexcept {
  relation_.forget();
  counted_cycles_ = last_count_ = 0;
  return set_up_player(kLamps, kCount) &&
         block_.execute(kLamps, pio::mov(pio::To::x, pio::From::null, true)) && block_.enable(1U << kLamps);
}

double Rp1Hardware::drift_sd(MonoTime at) const noexcept {
  return std::min(kCrystalsSd, kept_drift_sd_ + kDriftAges * to_seconds(at - drift_known_at_));
}

Rp1Hardware::Clocks Rp1Hardware::clocks() const noexcept {
  return {Duration{start_within_ns_.load()}, drift_.load(), drift_sd_.load()};
}

}  // namespace strobe::firmware
