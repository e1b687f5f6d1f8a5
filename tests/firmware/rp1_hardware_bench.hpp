// A Raspberry Pi 5's PIO as the sequencer's logic has it, on a simulated block and a virtual clock, for tests. What the pins
// did, and when, is the simulation's.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include "common/flash_sequencer/controller.hpp"
#include "firmware/rp1_pio/rp1_hardware.hpp"
#include "tests/firmware/pio_interpreter.hpp"

#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>

namespace strobe::testing::rp1_hardware {

using firmware::Input;
using firmware::Rp1Hardware;
using firmware::Rp1Pins;
namespace fs = flash_sequencer;
using fs::CutCause;
using fs::InputLine;
using fs::kTick_ns;
using fs::Phase;
using fs::Request;
using fs::Ticks;

inline constexpr unsigned kKeyPin = 5, kEstopPin = 6, kGatePin = 13;
inline Rp1Pins test_pins() {
  Rp1Pins pins;
  pins.outputs = {22, 23, 17, 18, Rp1Pins::kNotFitted, Rp1Pins::kNotFitted};
  pins.key = kKeyPin;
  pins.estop = kEstopPin;
  pins.gate = kGatePin;
  return pins;
}
inline std::size_t line_of(unsigned pin) {
  const Rp1Pins pins = test_pins();
  return static_cast<std::size_t>(std::find(pins.outputs.begin(), pins.outputs.end(), pin) - pins.outputs.begin());
}

/// The machine: its clock, and the wires to the block's and the kernel's inputs.
class Machine final : public VirtualTime, public firmware::Clock, public firmware::EdgeSource {
 public:
  explicit Machine(double drift, unsigned seed) : random_(seed), block(*this, drift, seed) {
    set(Input::key, true);
    set(Input::estop, false);
  }

  MonoTime at() const override { return time_; }
  void pass(Duration duration) override {
    const MonoTime end = time_ + duration;
    while (!wires_.empty() && wires_.front().time <= end) {
      const firmware::Edge wire = wires_.front();
      wires_.erase(wires_.begin());
      time_ = std::max(time_, wire.time);
      set(wire.input, wire.active);
      const bool both = wire.input == Input::key || wire.input == Input::estop;
      // The kernel's stamp is that of its interrupt.
      if (both || wire.active) stamped_.push_back({wire.input, time_ + draw(microseconds(1), microseconds(9)), wire.active});
    }
    time_ = end;
  }
  MonoTime now() noexcept override {
    pass(nanoseconds(30));
    return time_;
  }
  MonoTime spin_until(MonoTime instant) noexcept override {
    if (time_ < instant) pass(instant - time_);
    return time_;
  }
  std::optional<std::size_t> wait(MonoTime until, std::span<firmware::Edge> edges) noexcept override {
    while (time_ < until && !has_edge()) {
      MonoTime next = until;
      if (!wires_.empty()) next = std::min(next, wires_.front().time);
      if (!stamped_.empty()) next = std::min(next, stamped_.front().time);
      pass(std::max(next - time_, Duration{1}));
    }
    pass(draw(microseconds(2), late_wakes));
    if (stall > Duration{}) pass(std::exchange(stall, Duration{}));
    std::size_t count = 0;
    while (count < edges.size() && has_edge()) {
      edges[count++] = stamped_.front();
      stamped_.erase(stamped_.begin());
    }
    return count;
  }
  std::optional<std::size_t> poll(MonoTime until, std::span<firmware::Edge> edges) noexcept override {
    return wait(until, edges);
  }
  std::optional<bool> level(Input input) noexcept override {
    if (unreadable) return std::nullopt;
    return levels_.at(static_cast<std::size_t>(input));
  }
  std::int64_t kernel_overflows() const noexcept override { return 0; }

  /// A wire's logical level changes then.
  void change(MonoTime time, Input input, bool active) {
    wires_.push_back({input, time, active});
    std::stable_sort(wires_.begin(), wires_.end(), [](const auto& a, const auto& b) { return a.time < b.time; });
  }
  Duration draw(Duration least, Duration most) {
    return Duration{std::uniform_int_distribution<std::int64_t>(least.count(), most.count())(random_)};
  }

  Duration late_wakes = microseconds(80);
  Duration stall{};  ///< once, of the next wait
  bool unreadable = false;  ///< levels

 private:
  bool has_edge() const { return !stamped_.empty() && stamped_.front().time <= time_; }
  void set(Input input, bool active) {
    levels_.at(static_cast<std::size_t>(input)) = active;
    if (input == Input::key) block.input(kKeyPin, active);
    if (input == Input::estop) block.input(kEstopPin, !active);
    if (input == Input::gate) block.input(kGatePin, active);
  }

  MonoTime time_{milliseconds(5000)};
  std::mt19937 random_;
  std::array<bool, 6> levels_{};
  std::vector<firmware::Edge> wires_, stamped_;

 public:
  SimulatedPioBlock block;
};

/// A block that now and then fails, before or after it has done as it was told, or says what is not so.
class FlakyBlock final : public firmware::PioBlock {
 public:
  FlakyBlock(firmware::PioBlock& block, std::mt19937::result_type seed) : block_(block), random_(seed) {}
  double share = 0.0;

  bool load(std::span<const std::uint16_t> program) noexcept override {
    return call([&] { return block_.load(program); });
  }
  bool set_up(unsigned machine, const Registers& registers, unsigned address) noexcept override {
    return call([&] { return block_.set_up(machine, registers, address); });
  }
  bool execute(unsigned machine, std::uint16_t instruction) noexcept override {
    return call([&] { return block_.execute(machine, instruction); });
  }
  bool enable(unsigned machines) noexcept override { return call([&] { return block_.enable(machines); }); }
  bool disable(unsigned machines) noexcept override { return call([&] { return block_.disable(machines); }); }
  bool drive(unsigned pin) noexcept override { return call([&] { return block_.drive(pin); }); }
  std::optional<std::uint32_t> get(unsigned machine) noexcept override {
    if (fails()) return fails() ? std::optional(static_cast<std::uint32_t>(random_())) : std::nullopt;
    return block_.get(machine);
  }
  bool transfer(unsigned machine, std::span<const std::uint32_t> words) noexcept override {
    return call([&] { return block_.transfer(machine, words); });
  }
  bool transferring(unsigned machine) noexcept override { return fails() || block_.transferring(machine); }
  std::optional<unsigned> queued(unsigned machine) noexcept override {
    if (fails()) return fails() ? std::optional(0U) : std::nullopt;
    return block_.queued(machine);
  }

 private:
  bool fails() { return share > 0.0 && std::uniform_real_distribution<double>()(random_) < share; }
  template <typename Effect>
  bool call(Effect&& effect) {
    if (!fails()) return effect();
    if (std::bernoulli_distribution(0.5)(random_)) (void)effect();
    return false;
  }

  firmware::PioBlock& block_;
  std::mt19937 random_;
};

/// The whole sequencer: its logic on the block, with beats as strobed sends them.
struct Bench {
  Machine machine;
  FlakyBlock flaky;
  Rp1Hardware hardware;
  std::optional<fs::Controller> controller;
  fs::Decoder decoder;
  std::uint8_t number = 0;
  bool beats = true;
  MonoTime next_beat = machine.at();
  std::vector<fs::InputEdge> inputs;

  explicit Bench(double drift = 23e-6, std::mt19937::result_type seed = 1)
      : machine(drift, static_cast<unsigned>(seed)),
        flaky(machine.block, seed),
        hardware(flaky, machine, machine, test_pins(), seed) {
    CHECK_TRUE(hardware.take());
    controller.emplace(hardware, 1, false);
  }
  SimulatedPioBlock& block() { return machine.block; }

  void turn() {
    hardware.poll(machine.at() + microseconds(800));
    for (; machine.at() >= next_beat; next_beat += milliseconds(5)) {  // of another thread, which does not stall
      if (beats) ask(fs::to_frame(Request::beat), next_beat);
    }
    controller->turn();
    for (fs::InputEdge edge; hardware.pop_input(edge);) inputs.push_back(edge);
  }
  void turn_until(MonoTime end) {
    while (machine.at() < end) turn();
  }
  void turn_for(Duration duration) { turn_until(machine.at() + duration); }
  /// Alone: nobody turns it.
  void hang_for(Duration duration) {
    machine.pass(duration);
    block().advance();
  }

  fs::Status ask(fs::Frame request) { return ask(request, machine.at()); }
  fs::Status ask(fs::Frame request, MonoTime received) {
    request.number = ++number;
    fs::Frame reply;
    CHECK_TRUE(controller->answer(request, to_ns(received) / kTick_ns, reply));
    const auto status = fs::read_status(reply);
    CHECK_TRUE(status.has_value());
    return *status;
  }
  fs::Status carry_out(const fs::Frame& request) {
    const fs::Status status = ask(request);
    LONGS_EQUAL(fs::Refusal::none, status.refusal);
    return status;
  }
  void get_ready() {
    turn_for(milliseconds(20));
    carry_out(fs::to_frame(Request::reset));
    carry_out(fs::to_frame(fs::Limits{{100'000'000, 100'000'000, 100'000'000, 100'000'000, 0, 0}}));
  }
  void load(fs::Track track, const std::vector<fs::Edge>& edges) {
    for (std::size_t first = 0; first < edges.size() || first == 0; first += fs::Load::kMaxEdges) {
      fs::Load part;
      part.track = track;
      part.first = static_cast<std::uint16_t>(first);
      for (std::size_t i = first; i < edges.size() && part.count < fs::Load::kMaxEdges; ++i)
        part.edges[part.count++] = edges[i];
      carry_out(fs::to_frame(part));
      if (edges.empty()) break;
    }
  }
  /// The instant asked for.
  MonoTime begin(const std::vector<fs::Edge>& movers, const std::vector<fs::Edge>& lamps, Duration ahead,
                 std::optional<std::pair<Duration, Duration>> gate = {}) {
    load(fs::Track::movers, movers);
    load(fs::Track::lamps, lamps);
    fs::Arm arm{{static_cast<std::uint16_t>(movers.size()), static_cast<std::uint16_t>(lamps.size())},
                fs::train_crc(movers, lamps), static_cast<std::uint8_t>(gate ? 1 : 0)};
    const fs::Status armed = carry_out(fs::to_frame(arm));
    turn();
    fs::Start start;
    start.challenge = armed.challenge;
    start.at = to_ns(machine.at() + ahead) / kTick_ns;
    if (gate) {
      start.gate_from = gate->first.count() / kTick_ns;
      start.gate_until = gate->second.count() / kTick_ns;
    }
    block().pins.clear();
    carry_out(fs::to_frame(start));
    return from_ns(start.at * kTick_ns);
  }
  fs::Status play() {
    while (controller->phase() == Phase::playing) turn();
    block().advance();
    return ask(fs::to_frame(Request::beat));
  }
};

struct Seen {
  std::int64_t cycle;
  std::uint32_t levels;
};
/// Of a track's pins, in cycles; pins that change together once.
inline std::vector<Seen> seen(Bench& bench, fs::Track track) {
  std::vector<Seen> all;
  std::uint32_t levels = 0;
  for (const auto& change : bench.block().pins) {
    const std::size_t line = line_of(change.pin);
    if ((fs::outputs_of(track) >> line & 1U) == 0) continue;
    levels = change.level ? levels | 1U << line : levels & ~(1U << line);
    const std::int64_t cycle = bench.block().cycle_of(change.time + nanoseconds(2));  // that rounding made earlier
    if (!all.empty() && all.back().cycle == cycle) all.back().levels = levels;
    else all.push_back({cycle, levels});
  }
  return all;
}

inline std::vector<fs::Edge> pulses(unsigned line, std::size_t count, Duration before, Duration on, Duration off) {
  std::vector<fs::Edge> edges;
  const auto ticks = [](Duration length) { return static_cast<std::uint32_t>(length.count() / kTick_ns); };
  for (std::size_t i = 0; i < count; ++i) {
    edges.push_back({ticks(i == 0 ? before : off), 1U << line});
    edges.push_back({ticks(on), 0});
  }
  return edges;
}

/// A track's edges that change a level each; no more than four in a row nearer to one another than the DMA fetches.
inline std::vector<fs::Edge> drawn_edges(std::mt19937& random, unsigned first_line, std::size_t most, Duration longest) {
  std::uniform_real_distribution<double> fraction;
  std::vector<fs::Edge> edges;
  const auto count = std::uniform_int_distribution<std::size_t>(2, most)(random);
  std::uint32_t levels = 0;
  int short_ones = 0;
  for (std::size_t i = 0; i + 1 < count || levels != 0; ++i) {
    const bool is_short = short_ones < 3 && fraction(random) < 0.2;
    short_ones = is_short ? short_ones + 1 : 0;
    const double least = is_short ? 16.0 : 1000.0, greatest = is_short ? 50.0 : static_cast<double>(longest.count()) / kTick_ns;
    const double delay = least * std::pow(greatest / least, fraction(random));
    std::uint32_t next = levels;
    while (next == levels) next = static_cast<std::uint32_t>(random() & 3U) << first_line;
    if (i + 1 >= count) next = 0;
    levels = next;
    edges.push_back({static_cast<std::uint32_t>(delay), levels});
  }
  return edges;
}

/// Each edge against the plan by the drift that the hardware has told, from the track's first one on: 1 cycle.
inline void check_edges(Bench& bench, fs::Track track, const std::vector<fs::Edge>& plan) {
  const std::vector<Seen> edges = seen(bench, track);
  CHECK_EQUAL(plan.size(), edges.size());
  const double cycle_ns = 5.0 * (1.0 + bench.hardware.clocks().drift);
  Ticks at = 0;
  for (std::size_t i = 0; i < plan.size(); ++i) {
    at += i == 0 ? 0 : plan[i].delay;
    LONGS_EQUAL(plan[i].levels, edges[i].levels);
    const double due = static_cast<double>(at * kTick_ns) / cycle_ns;
    const auto off = static_cast<double>(edges[i].cycle - edges.front().cycle) - due;
    if (std::abs(off) > 1.0) FAIL(StringFromFormat("edge %d is %g cycles off", static_cast<int>(i), off).asCharString());
  }
}

/// The true begin, from the first edge, against the told one.
inline double begin_error_ns(Bench& bench, fs::Track track, const std::vector<fs::Edge>& plan, Ticks told) {
  const MonoTime first = bench.block().time_of(seen(bench, track).front().cycle);
  return static_cast<double>(to_ns(first) - (told + plan.front().delay) * kTick_ns);
}

/// What many trains are made of.
inline const std::vector<fs::Edge> kLongShutter = pulses(0, 1, milliseconds(1), milliseconds(60), {});
inline const std::vector<fs::Edge> kFlashes = pulses(2, 50, milliseconds(2), microseconds(900), microseconds(100));

inline bool all_low(Bench& bench) {
  bench.block().advance();
  std::array<bool, 32> levels{};
  for (const auto& change : bench.block().pins) levels.at(change.pin) = change.level;
  return std::none_of(levels.begin(), levels.end(), [](bool level) { return level; });
}
inline MonoTime last_change(Bench& bench) {
  CHECK_FALSE(bench.block().pins.empty());
  return bench.block().pins.back().time;
}

}  // namespace strobe::testing::rp1_hardware
