// A flash sequencer on a virtual clock, for tests: the sequencer's own logic on a chip that plays to the tick, at the
// other end of a line of 1,000,000 baud that can lose and damage bytes. It is clock and line at once: time passes in
// sleeps, in spins and a little with each reading.
#pragma once

#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>
#include <memory>
#include <random>
#include <vector>

#include "common/flash_sequencer/controller.hpp"
#include "firmware/flash_sequencer/inputs.hpp"
#include "firmware/flash_sequencer/outputs.hpp"
#include "tests/support/allocations.hpp"
#include "tests/support/virtual_rig.hpp"

namespace strobe::testing {

/// What a pin did, in true time.
struct PinChange {
  MonoTime time;
  flash_sequencer::OutputLine line;
  bool active;
};

class VirtualSequencerChip final : public flash_sequencer::Hardware {
 public:
  using Ticks = flash_sequencer::Ticks;

  double drift = 23e-6;  ///< its crystal is too slow by so much
  MonoTime started = from_ns(1'234'567'891);
  std::uint8_t levels = flash_sequencer::bit(flash_sequencer::InputLine::key);
  std::vector<PinChange> pins;

  Ticks ticks(MonoTime at) const {
    return static_cast<Ticks>(
        std::floor(static_cast<double>((at - started).count()) * (1.0 - drift) / flash_sequencer::kTick_ns));
  }
  MonoTime time_of(Ticks ticks) const {
    return started + Duration{std::llround(static_cast<double>(ticks * flash_sequencer::kTick_ns) / (1.0 - drift))};
  }
  /// Plays what is due until then.
  void advance(MonoTime until) {
    now_ = std::max(now_, until);
    for (;;) {
      int next = -1;
      for (int track = 0; track < 2; ++track) {
        const Ticks due = due_of(track);
        if (due != flash_sequencer::kNoTicks && due <= ticks(now_) && (next < 0 || due < due_of(next))) next = track;
      }
      if (starts_at_ != flash_sequencer::kNoTicks && ticks(now_) >= starts_at_) told_.started = starts_at_;
      if (next < 0) return;
      const auto index = static_cast<std::size_t>(next);
      const MonoTime at = time_of(due_of(next));
      last_[index] = due_of(next);
      const std::uint32_t mask = flash_sequencer::outputs_of(static_cast<flash_sequencer::Track>(next));
      drive((outputs_ & ~mask) | (tracks_[index][told_.played[index]++].levels & mask), at);
    }
  }
  /// When the next edge is due; MonoTime::max(): none is.
  MonoTime next_edge() const {
    MonoTime next = MonoTime::max();
    for (int track = 0; track < 2; ++track)
      if (due_of(track) != flash_sequencer::kNoTicks) next = std::min(next, time_of(due_of(track)) + nanoseconds(8));
    return next;
  }
  void set_input(flash_sequencer::InputLine line, bool active, MonoTime at) {
    advance(at);
    const std::uint8_t bit = flash_sequencer::bit(line);
    levels = static_cast<std::uint8_t>(active ? levels | bit : levels & ~bit);
    const bool key_or_estop = line == flash_sequencer::InputLine::key || line == flash_sequencer::InputLine::estop;
    if (released_ && forbidden() != flash_sequencer::CutCause::none) {
      by_itself_ = forbidden();
      switch_off();
    }
    const Ticks stamp = ticks(at);
    if (line == flash_sequencer::InputLine::gate && active && listens_ &&
        told_.burst_started == flash_sequencer::kNoTicks) {
      told_.burst_started = last_[1] = stamp;
    }
    if (active || key_or_estop || line == flash_sequencer::InputLine::xsync)
      edges_.push_back({0, line, static_cast<std::uint8_t>(active), stamp});
  }

  /// The e-stop bounces at the call, from now on, of cut, release, prepare, cut_by_itself, inputs or now that comes after
  /// so many others.
  int bounces_after = -1;
  void bounce() {
    if (bounces_after < 0 || bounces_after-- > 0) return;
    for (const bool pressed : {true, false}) set_input(flash_sequencer::InputLine::estop, pressed, now_);
  }

  Ticks now() override {
    bounce();
    return ticks(now_);
  }
  void prepare(std::span<flash_sequencer::Edge> movers, std::span<flash_sequencer::Edge> lamps) override {
    bounce();
    tracks_ = {movers, lamps};
    told_ = {};
    starts_at_ = flash_sequencer::kNoTicks;
  }
  void start(Ticks at, bool gated) override {
    starts_at_ = last_[0] = last_[1] = at;
    gated_ = gated;
  }
  void listen_to_gate(bool listens) override { listens_ = listens; }
  flash_sequencer::Progress progress() override { return told_; }
  void cut() override {
    bounce();
    switch_off();
  }
  bool release() override {
    bounce();
    by_itself_ = flash_sequencer::CutCause::none;
    return released_ = forbidden() == flash_sequencer::CutCause::none;
  }
  flash_sequencer::CutCause cut_by_itself() override {
    bounce();
    return by_itself_;
  }
  std::uint8_t inputs() override {
    bounce();
    return levels;
  }
  std::uint8_t outputs() override { return static_cast<std::uint8_t>(outputs_); }
  bool pop_input(flash_sequencer::InputEdge& edge) override {
    if (edges_.empty()) return false;
    edge = edges_.front();
    edges_.pop_front();
    return true;
  }
  std::uint16_t lost_inputs() override { return 0; }
  std::uint32_t random() override { return ++drawn_; }

 private:
  flash_sequencer::CutCause forbidden() const {
    if ((levels & flash_sequencer::bit(flash_sequencer::InputLine::estop)) != 0) return flash_sequencer::CutCause::estop;
    return (levels & flash_sequencer::bit(flash_sequencer::InputLine::key)) != 0 ? flash_sequencer::CutCause::none
                                                                                : flash_sequencer::CutCause::key;
  }
  Ticks due_of(int track) const {
    const auto index = static_cast<std::size_t>(track);
    const bool begun = starts_at_ != flash_sequencer::kNoTicks &&
                       (track == 0 || !gated_ || told_.burst_started != flash_sequencer::kNoTicks);
    if (!released_ || !begun || told_.played[index] == tracks_[index].size()) return flash_sequencer::kNoTicks;
    return last_[index] + tracks_[index][told_.played[index]].delay;
  }
  void switch_off() {
    drive(0, now_);
    released_ = listens_ = false;
    starts_at_ = flash_sequencer::kNoTicks;
  }
  void drive(std::uint32_t outputs, MonoTime at) {
    for (std::size_t line = 0; line < flash_sequencer::kOutputCount; ++line) {
      if ((((outputs ^ outputs_) >> line) & 1U) == 0) continue;
      pins.push_back({at, static_cast<flash_sequencer::OutputLine>(line), ((outputs >> line) & 1U) != 0});
    }
    outputs_ = outputs;
  }

  MonoTime now_ = started;
  std::array<std::span<flash_sequencer::Edge>, 2> tracks_;
  std::array<Ticks, 2> last_{};
  flash_sequencer::Progress told_;
  Ticks starts_at_ = flash_sequencer::kNoTicks;
  bool gated_ = false, listens_ = false, released_ = false;
  flash_sequencer::CutCause by_itself_ = flash_sequencer::CutCause::none;
  std::uint32_t outputs_ = 0, drawn_ = 0;
  std::deque<flash_sequencer::InputEdge> edges_;
};

class VirtualSequencerLine final : public Clock, public SerialLine {
 public:
  MonoTime time = from_ns(5'000'000'000);
  VirtualSequencerChip chip;
  std::unique_ptr<flash_sequencer::Controller> controller;
  std::function<void()> beat;          ///< called every 4 ms
  bool answers = true, here = true;    ///< the sequencer; the line
  bool writable = true, tells_departure = true;
  double damaged = 0.0;                ///< share of the bytes, either way
  Duration reader_delay = microseconds(30);  ///< mean time from a byte's end to the thread that reads it
  bool seen_by_lamps = true;           ///< sensors answer flashes
  const AllocationCounter* counter = nullptr;
  std::int64_t own_allocations = 0;  ///< of what it counts those of the bench itself

  VirtualSequencerLine() { boot(); }
  /// The microcontroller starts anew.
  void boot(bool by_watchdog = false) {
    chip.started = time - microseconds(17);
    controller = std::make_unique<flash_sequencer::Controller>(chip, 1000 + ++boots_, by_watchdog);
    to_sequencer_.clear();
    to_loop_.clear();
    decoder_ = {};
    last_pin_ = chip.pins.size();
  }
  /// An input changes, in the future.
  void schedule(MonoTime at, flash_sequencer::InputLine line, bool active) {
    inputs_.push_back({at, line, active});
    std::stable_sort(inputs_.begin(), inputs_.end(), [](const auto& a, const auto& b) { return a.at < b.at; });
  }
  /// The loop's core stands still from then on for so long; beats and sequencer do not. In order of time.
  void freeze(MonoTime when, Duration how_long) { freezes_.push_back({when, how_long}); }

  /// Those frames never leave the sequencer.
  std::function<bool(const flash_sequencer::Frame&)> loses;
  void lose_reports_of(flash_sequencer::InputLine line) {
    loses = [line](const flash_sequencer::Frame& frame) {
      const auto edge = flash_sequencer::read_input(frame);
      return edge && edge->line == line;
    };
  }

  /// Comes to the loop as if the sequencer had sent it.
  void pretend(const flash_sequencer::Frame& frame) { reply(frame, time); }

  MonoTime now() noexcept override {
    pass_to(time + nanoseconds(20));
    return time;
  }
  MonoTime spin_until(MonoTime instant) noexcept override {
    pass_to(std::max(instant, time) + nanoseconds(30));
    return time;
  }
  bool write(std::span<const std::uint8_t> bytes) noexcept override {
    if (!writable) return false;
    pass_to(time + microseconds(2));
    const std::int64_t before = counted();
    for (const std::uint8_t byte : bytes) {
      sending_free_ = std::max(sending_free_, time + delay(microseconds(3))) + kByteTime;
      to_sequencer_.push_back({sending_free_, on_the_way(byte)});
    }
    if (!busy_) own_allocations += counted() - before;
    return true;
  }
  std::optional<Departure> departure(std::int64_t, MonoTime, MonoTime) noexcept override {
    if (!tells_departure) return std::nullopt;
    const MonoTime left = sending_free_;
    return Departure{left - delay(microseconds(1)), left + delay(microseconds(1))};
  }
  std::optional<std::size_t> read(std::span<std::uint8_t> bytes) noexcept override {
    pass_to(time + microseconds(1));
    if (!here) return std::nullopt;
    std::size_t count = 0;
    while (count < bytes.size() && !to_loop_.empty() && to_loop_.front().arrives <= time) {
      bytes[count++] = to_loop_.front().value;
      to_loop_.pop_front();
    }
    return count;
  }
  bool wait(MonoTime until) noexcept override {
    for (;;) {
      if (!here || (!to_loop_.empty() && to_loop_.front().arrives <= time)) return true;
      if (time >= until) return false;
      MonoTime next = std::min(until, next_event());
      if (!to_loop_.empty()) next = std::min(next, to_loop_.front().arrives);
      pass_to(std::max(next, time + nanoseconds(1)));
    }
  }
  bool poll(MonoTime until) noexcept override { return wait(until); }

 private:
  static constexpr Duration kTurn = microseconds(500);
  struct Byte {
    MonoTime arrives;
    std::uint8_t value;
  };
  struct InputChange {
    MonoTime at;
    flash_sequencer::InputLine line;
    bool active;
  };
  struct Freeze {
    MonoTime when;
    Duration how_long;
  };

  std::int64_t counted() const { return counter != nullptr ? counter->count() : 0; }
  Duration delay(Duration mean) {
    return Duration{std::llround(std::exponential_distribution<double>(1.0 / static_cast<double>(mean.count()))(random_))};
  }
  std::uint8_t on_the_way(std::uint8_t byte) {
    if (std::uniform_real_distribution<double>()(random_) >= damaged) return byte;
    return static_cast<std::uint8_t>(byte ^ (1U << (random_() % 8)));
  }
  MonoTime next_event() const {
    MonoTime next = std::min({turn_at_, beat_at_, chip.next_edge()});
    if (!to_sequencer_.empty()) next = std::min(next, to_sequencer_.front().arrives);
    if (!inputs_.empty()) next = std::min(next, inputs_.front().at);
    return next;
  }
  void pass_to(MonoTime end) {
    if (busy_) {
      time = std::max(time, end);
      return;
    }
    for (; !freezes_.empty() && freezes_.front().when < end; freezes_.pop_front())
      end = std::max(end, freezes_.front().when + freezes_.front().how_long);
    busy_ = true;
    const std::int64_t before = counted();
    for (MonoTime next = next_event(); next <= end; next = next_event()) {
      time = std::max(time, next);
      happen(next);
    }
    own_allocations += counted() - before;
    busy_ = false;
    time = std::max(time, end);
  }
  void happen(MonoTime at) {
    chip.advance(at);
    see_flashes();
    if (!inputs_.empty() && inputs_.front().at == at) {
      const InputChange change = inputs_.front();
      inputs_.pop_front();
      chip.set_input(change.line, change.active, at);
    } else if (!to_sequencer_.empty() && to_sequencer_.front().arrives == at) {
      take(to_sequencer_.front().value, at);
      to_sequencer_.pop_front();
    } else if (beat_at_ == at) {
      beat_at_ += Heartbeat::kEvery;
      if (beat) beat();
    } else if (turn_at_ == at) {
      turn_at_ += kTurn;
      if (answers) controller->turn();
      flash_sequencer::Frame report;
      while (answers && controller->next_input(report)) reply(report, at);
    }
  }
  void take(std::uint8_t byte, MonoTime at) {
    const flash_sequencer::Frame* request = decoder_.take(byte);
    flash_sequencer::Frame answer;
    if (request != nullptr && answers && controller->answer(*request, chip.ticks(at), answer))
      reply(answer, at + Duration{flash_sequencer::kReplyAfter * flash_sequencer::kTick_ns});
  }
  void reply(const flash_sequencer::Frame& frame, MonoTime at) {
    if (loses && loses(frame)) return;
    std::array<std::uint8_t, flash_sequencer::kMaxFrame> wire;
    const std::size_t size = flash_sequencer::encode(frame, wire);
    for (std::size_t i = 0; i < size; ++i) {
      replying_free_ = std::max(replying_free_, at) + kByteTime;
      // Whoever reads is woken a while after the byte, and by the last one at the latest.
      const MonoTime last = to_loop_.empty() ? MonoTime{} : to_loop_.back().arrives;
      to_loop_.push_back({std::max(last, replying_free_ + delay(reader_delay)), on_the_way(wire[i])});
    }
  }
  void see_flashes() {
    using flash_sequencer::InputLine;
    using flash_sequencer::OutputLine;
    for (; last_pin_ < chip.pins.size(); ++last_pin_) {
      const PinChange& pin = chip.pins[last_pin_];
      const bool lamp = pin.line == OutputLine::strobe_a || pin.line == OutputLine::strobe_b;
      if (!lamp || !pin.active || !seen_by_lamps) continue;
      const InputLine sensor = pin.line == OutputLine::strobe_a ? InputLine::sensor_a : InputLine::sensor_b;
      schedule(std::max(pin.time + microseconds(12), time), sensor, true);
      schedule(std::max(pin.time + microseconds(60), time), sensor, false);
    }
  }

  std::mt19937_64 random_{20261128};
  flash_sequencer::Decoder decoder_;
  std::deque<Byte> to_sequencer_, to_loop_;
  std::deque<InputChange> inputs_;
  std::deque<Freeze> freezes_;
  MonoTime sending_free_, replying_free_;
  MonoTime turn_at_ = time, beat_at_ = time;
  std::size_t last_pin_ = 0;
  std::uint64_t boots_ = 0;
  bool busy_ = false;
};

/// The whole of strobed's side of the link, connected, with beats.
struct FlashSequencerBench {
  Rig config;
  VirtualSequencerLine line;
  Heartbeat heartbeat{line, line};
  FlashSequencerLink link{line, heartbeat, line};
  FlashSequencerInputs inputs;
  FlashSequencerOutputs outputs;
  Result<void> connected;

  explicit FlashSequencerBench(const Rig& rig = shipped_rig())
      : config(rig),
        inputs(config, link, line),
        outputs(config, link, line),
        connected(link.connect(milliseconds(1000))) {
    line.beat = [this] { heartbeat.beat(); };
  }
};

}  // namespace strobe::testing
