// A Raspberry Pi 5's own way on a virtual clock, for tests: strobed's side of the link, the line within strobed, the
// sequencer's logic on the RP1's port, and the PIO block that is simulated to the cycle. One thread: time passes in
// sleeps, in spins, in calls to the block, and a little with each reading; the sequencer's thread and the beats have their
// turns meanwhile.
#pragma once

#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>
#include <random>
#include <vector>

#include "firmware/flash_sequencer/inputs.hpp"
#include "firmware/flash_sequencer/outputs.hpp"
#include "firmware/rp1_pio/local_sequencer.hpp"
#include "tests/firmware/pio_interpreter.hpp"
#include "tests/support/virtual_rig.hpp"

namespace strobe::testing {

/// Pins of firmware/boards/raspberry-pi-5.toml.
namespace rp1_pin {
inline constexpr unsigned strobe_a = 17, strobe_b = 18, shutter = 22, trigger = 23, gate = 12, key = 16, estop = 20;
}

inline firmware::Rp1Pins rp1_pins() {
  constexpr unsigned kNone = firmware::Rp1Pins::kNotFitted;
  return {.outputs = {rp1_pin::shutter, rp1_pin::trigger, rp1_pin::strobe_a, rp1_pin::strobe_b, kNone, kNone}, .key = rp1_pin::key, .estop = rp1_pin::estop, .gate = rp1_pin::gate};
}

/// Clock, block, and the kernel's edges as the sequencer's thread has them.
class VirtualRp1 final : public firmware::Clock, public firmware::EdgeSource, public VirtualTime {
 public:
  /// A stamp is so late, in the mean and at most; whoever sleeps is woken so long after it.
  static constexpr Duration kStampDelay = microseconds(1), kMaxStampDelay = microseconds(5), kWakeDelay = microseconds(10);

  MonoTime time = from_ns(5'000'000'000);
  SimulatedPioBlock block{*this};
  std::function<void()> turn;  ///< of the sequencer's thread
  std::function<void()> beat;  ///< called every 4 ms

  VirtualRp1() {
    for (const unsigned pin : {rp1_pin::key, rp1_pin::estop}) block.input(pin, true);
  }
  /// A pin changes, in the future.
  void schedule(MonoTime at, unsigned pin, bool level) {
    inputs_.push_back({at, pin, level});
    std::stable_sort(inputs_.begin(), inputs_.end(), [](const auto& a, const auto& b) { return a.at < b.at; });
  }
  void wake_sequencer() { turn_at_ = std::min(turn_at_, time + kWakeDelay); }
  /// Neither the sequencer's thread nor the beats run until then; pins and block do.
  void stop_threads(MonoTime until) { stopped_until_ = until; }

  MonoTime at() const override { return time; }
  void pass(Duration duration) override { pass_to(time + duration); }
  /// At the latest until then, and no further than the next thing that happens.
  void sleep(MonoTime until) { pass_to(std::clamp(next_software(), time + nanoseconds(1), std::max(until, time + nanoseconds(1)))); }

  MonoTime now() noexcept override {
    pass(nanoseconds(20));
    return time;
  }
  MonoTime spin_until(MonoTime instant) noexcept override {
    pass_to(std::max(instant, time) + nanoseconds(30));
    return time;
  }
  /// Returns at once: the thread is given its next turn when it would have been woken.
  std::optional<std::size_t> wait(MonoTime until, std::span<firmware::Edge> edges) noexcept override {
    turn_at_ = std::max(until, time + nanoseconds(1));
    pass(microseconds(2));
    std::size_t count = 0;
    while (count < edges.size() && !edges_.empty() && edges_.front().time + kWakeDelay <= time) {
      edges[count++] = edges_.front();
      edges_.pop_front();
    }
    return count;
  }
  std::optional<std::size_t> poll(MonoTime until, std::span<firmware::Edge> edges) noexcept override {
    return wait(until, edges);
  }
  std::optional<bool> level(firmware::Input input) noexcept override {
    pass(microseconds(1));
    const std::uint32_t pins = block.interpreter().pins();
    if (input == firmware::Input::estop) return (pins >> rp1_pin::estop & 1U) == 0;
    const unsigned pin = input == firmware::Input::key ? rp1_pin::key : rp1_pin::gate;
    return (pins >> pin & 1U) != 0;
  }
  std::int64_t kernel_overflows() const noexcept override { return 0; }

 private:
  struct PinLevel {
    MonoTime at;
    unsigned pin;
    bool level;
  };

  MonoTime next_software() const {
    MonoTime next = std::min(turn_at_, beat_at_);
    if (!edges_.empty()) next = std::min(next, edges_.front().time + kWakeDelay);
    return std::max(next, stopped_until_);
  }
  void pass_to(MonoTime end) {
    while (!busy_ && next_software() <= end) {
      pins_until(next_software());
      busy_ = true;
      const bool beats = beat_at_ <= time;
      if (beats) beat_at_ = time + firmware::Heartbeat::kEvery;
      if (beats && beat) beat();
      if (!beats) turn_at_ = time + milliseconds(1);
      if (!beats && turn) turn();
      busy_ = false;
    }
    pins_until(end);
  }
  void pins_until(MonoTime end) {
    while (!inputs_.empty() && inputs_.front().at <= end) {
      const PinLevel change = inputs_.front();
      inputs_.pop_front();
      time = std::max(time, change.at);
      block.input(change.pin, change.level);
      stamp(change);
    }
    time = std::max(time, end);
  }
  void stamp(const PinLevel& change) {
    std::exponential_distribution<double> drawn(1.0 / static_cast<double>(kStampDelay.count()));
    const Duration delay = std::min(kMaxStampDelay, Duration{std::llround(drawn(random_))});
    const auto input = change.pin == rp1_pin::key     ? firmware::Input::key
                       : change.pin == rp1_pin::estop ? firmware::Input::estop
                                              : firmware::Input::gate;
    const bool active = change.level != (change.pin == rp1_pin::estop);
    if (input == firmware::Input::gate && !active) return;
    MonoTime stamp = change.at + delay;
    if (!edges_.empty()) stamp = std::max(stamp, edges_.back().time);
    edges_.push_back({input, stamp, active});
  }

  std::mt19937_64 random_{20261128};
  std::deque<PinLevel> inputs_;
  std::deque<firmware::Edge> edges_;
  MonoTime turn_at_ = time, beat_at_ = time, stopped_until_ = MonoTime::min();
  bool busy_ = false;
};

/// The loop's end of the line: its sleeps are the virtual clock's.
class VirtualLocalLine final : public firmware::SerialLine {
 public:
  explicit VirtualLocalLine(VirtualRp1& rp1) : rp1_(rp1) {}
  firmware::LocalLine& within() { return line_; }

  bool write(std::span<const std::uint8_t> bytes) noexcept override {
    const bool written = line_.write(bytes);
    rp1_.wake_sequencer();
    rp1_.pass(microseconds(2));
    return written;
  }
  std::optional<Departure> departure(std::int64_t bytes, MonoTime before, MonoTime after) noexcept override {
    return line_.departure(bytes, before, after);
  }
  Pace pace() const noexcept override { return line_.pace(); }
  std::optional<std::size_t> read(std::span<std::uint8_t> bytes) noexcept override {
    rp1_.pass(microseconds(1));
    return line_.read(bytes);
  }
  bool wait(MonoTime until) noexcept override {
    for (;;) {
      if (line_.wait(MonoTime{})) return true;
      if (rp1_.time >= until) return false;
      rp1_.sleep(until);
    }
  }
  bool poll(MonoTime until) noexcept override { return wait(until); }

 private:
  VirtualRp1& rp1_;
  firmware::LocalLine line_{rp1_};
};

/// The whole of it, connected, with beats.
struct Rp1Bench {
  firmware::Rig config;
  VirtualRp1 rp1;
  VirtualLocalLine line{rp1};
  firmware::Rp1Hardware hardware{rp1.block, rp1, rp1, rp1_pins(), 37};
  bool taken = hardware.take();
  firmware::LocalSequencer sequencer{hardware, line.within(), rp1, 1001};
  firmware::Heartbeat heartbeat{line, rp1};
  firmware::FlashSequencerLink link{line, heartbeat, rp1};
  firmware::FlashSequencerInputs inputs;
  firmware::FlashSequencerOutputs outputs;
  Result<void> connected;

  explicit Rp1Bench(const firmware::Rig& rig = shipped_rig())
      : config(rig), inputs(config, link, rp1), outputs(config, link, rp1) {
    // Twice: a turn begins with the sleep that its thread would be in.
    rp1.turn = [this] {
      sequencer.turn();
      sequencer.turn();
    };
    connected = link.connect(milliseconds(1000));
    rp1.beat = [this] { heartbeat.beat(); };
  }
};

}  // namespace strobe::testing
