// A Raspberry Pi 5's PIO as the sequencer's logic has it, on a simulated block and a virtual clock. What the pins did, and
// when, is the simulation's.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

#include "common/flash_sequencer/controller.hpp"
#include "firmware/rp1_pio/rp1_hardware.hpp"
#include "tests/firmware/pio_interpreter.hpp"

#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::testing;
using firmware::Input;
using firmware::Rp1Hardware;
using firmware::Rp1Pins;

namespace {

namespace fs = flash_sequencer;
using fs::CutCause;
using fs::InputLine;
using fs::kTick_ns;
using fs::Phase;
using fs::Request;
using fs::Ticks;

constexpr unsigned kKeyPin = 5, kEstopPin = 6, kGatePin = 13;
Rp1Pins test_pins() {
  Rp1Pins pins;
  pins.outputs = {22, 23, 17, 18, Rp1Pins::kNotFitted, Rp1Pins::kNotFitted};
  pins.key = kKeyPin;
  pins.estop = kEstopPin;
  pins.gate = kGatePin;
  return pins;
}
std::size_t line_of(unsigned pin) {
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
std::vector<Seen> seen(Bench& bench, fs::Track track) {
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

std::vector<fs::Edge> pulses(unsigned line, std::size_t count, Duration before, Duration on, Duration off) {
  std::vector<fs::Edge> edges;
  const auto ticks = [](Duration length) { return static_cast<std::uint32_t>(length.count() / kTick_ns); };
  for (std::size_t i = 0; i < count; ++i) {
    edges.push_back({ticks(i == 0 ? before : off), 1U << line});
    edges.push_back({ticks(on), 0});
  }
  return edges;
}

/// A track's edges that change a level each; no more than four in a row nearer to one another than the DMA fetches.
std::vector<fs::Edge> drawn_edges(std::mt19937& random, unsigned first_line, std::size_t most, Duration longest) {
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
void check_edges(Bench& bench, fs::Track track, const std::vector<fs::Edge>& plan) {
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
double begin_error_ns(Bench& bench, fs::Track track, const std::vector<fs::Edge>& plan, Ticks told) {
  const MonoTime first = bench.block().time_of(seen(bench, track).front().cycle);
  return static_cast<double>(to_ns(first) - (told + plan.front().delay) * kTick_ns);
}

}  // namespace

TEST_GROUP(Rp1Hardware) {
  const std::vector<fs::Edge> long_shutter = pulses(0, 1, milliseconds(1), milliseconds(60), {});
  const std::vector<fs::Edge> flashes = pulses(2, 50, milliseconds(2), microseconds(900), microseconds(100));

  static bool all_low(Bench& bench) {
    bench.block().advance();
    std::array<bool, 32> levels{};
    for (const auto& change : bench.block().pins) levels.at(change.pin) = change.level;
    return std::none_of(levels.begin(), levels.end(), [](bool level) { return level; });
  }
  static MonoTime last_change(Bench& bench) {
    CHECK_FALSE(bench.block().pins.empty());
    return bench.block().pins.back().time;
  }
};

TEST(Rp1Hardware, EachEdgeOfADrawnTrainIsWithinACycleOfItsPlan) {
  const char* const asked = std::getenv("STROBE_TRAINS");
  const int trains = asked == nullptr ? 200 : std::atoi(asked);
  constexpr unsigned kSeed = 20261128;
  UT_PRINT(StringFromFormat("%d trains, seed %u", trains, kSeed).asCharString());
  std::mt19937 random(kSeed);
  double worst_begin = 0.0, worst_asked_ns = 0.0, edges = 0.0;
  constexpr int kTrainsOfABench = 20;
  std::optional<Bench> bench;
  for (int i = 0; i < trains; ++i) {
    if (i % kTrainsOfABench == 0) {
      const double drift = std::uniform_real_distribution<double>(-50e-6, 50e-6)(random);
      bench.emplace(drift, random());
      bench->get_ready();
      bench->turn_for(std::uniform_int_distribution<int>(0, 3)(random) * milliseconds(1000));
    }
    const auto movers = i % 7 == 3 ? std::vector<fs::Edge>{} : drawn_edges(random, 0, 12, milliseconds(20));
    const auto lamps = i % 7 == 5 ? std::vector<fs::Edge>{} : drawn_edges(random, 2, 100, milliseconds(2));
    const MonoTime asked_for =
        bench->begin(movers, lamps, std::uniform_int_distribution<int>(520, 80'000)(random) * microseconds(1));
    const fs::Status status = bench->play();
    LONGS_EQUAL(CutCause::none, status.cut);
    LONGS_EQUAL(Phase::idle, status.phase);
    CHECK_EQUAL(movers.size(), status.played[0]);
    CHECK_EQUAL(lamps.size(), status.played[1]);
    LONGS_EQUAL(0, status.outputs);
    check_edges(*bench, fs::Track::movers, movers);
    check_edges(*bench, fs::Track::lamps, lamps);
    if (!movers.empty() && !lamps.empty()) {
      const auto apart = static_cast<double>(seen(*bench, fs::Track::lamps).front().cycle - seen(*bench, fs::Track::movers).front().cycle);
      const double due = 8.0 * (static_cast<double>(lamps.front().delay) - static_cast<double>(movers.front().delay));
      DOUBLES_EQUAL(due / 5.0 / (1.0 + bench->hardware.clocks().drift), apart, 1.0);
    }
    // A tick of rounding, and the first edge's cycle.
    const double within_ns = static_cast<double>(bench->hardware.clocks().start_within.count()) + 13.0;
    const auto track = movers.empty() ? fs::Track::lamps : fs::Track::movers;
    const double drift_ns = 4.0 * bench->hardware.clocks().drift_sd * 20e6;
    const double off = std::abs(begin_error_ns(*bench, track, movers.empty() ? lamps : movers, status.started));
    if (off > within_ns + drift_ns) FAIL(StringFromFormat("begun %g ns off, told %g", off, within_ns).asCharString());
    worst_begin = std::max(worst_begin, off);
    worst_asked_ns = std::max(worst_asked_ns, std::abs(static_cast<double>(status.started * kTick_ns - to_ns(asked_for))));
    edges += static_cast<double>(movers.size() + lamps.size());
  }
  if (asked != nullptr)
    UT_PRINT(StringFromFormat("%g edges; begin known to %g ns, %g ns from the instant asked for", edges, worst_begin,
                              worst_asked_ns).asCharString());
}

TEST(Rp1Hardware, ATrainBeginsAtItsInstantWhereCallsTakeNoTime) {
  Bench bench;
  bench.get_ready();
  bench.block().fastest_call = bench.block().slowest_call = nanoseconds(10);
  const MonoTime asked = bench.begin(long_shutter, flashes, milliseconds(60));
  const fs::Status status = bench.play();
  // 30 ns of each reading of the clock, a tick, a cycle; thrice 60 ppm of 40 ms from the machines' start to the instant, as the drift
  // is not known yet.
  CHECK_TRUE(bench.hardware.clocks().start_within < nanoseconds(30 + 7200));
  DOUBLES_EQUAL(0.0, static_cast<double>(status.started * kTick_ns - to_ns(asked)), 73.0);

  bench.turn_for(milliseconds(5000));
  bench.begin(long_shutter, flashes, milliseconds(60));
  DOUBLES_EQUAL(0.0, begin_error_ns(bench, fs::Track::movers, long_shutter, bench.play().started), 43.0);
  CHECK_TRUE(bench.hardware.clocks().start_within < nanoseconds(73));
}

// ---- what cuts ----

TEST(Rp1Hardware, EstopAndKeyCutWithinAMicrosecondWhateverTheProgramDoes) {
  std::mt19937 random(11);
  for (int i = 0; i < 60; ++i) {
    Bench bench(30e-6, random());
    bench.get_ready();
    const MonoTime begin = bench.begin(long_shutter, flashes, milliseconds(30));
    const MonoTime press = begin + milliseconds(3) + bench.machine.draw({}, milliseconds(40));
    const bool by_key = i % 2 == 0;
    bench.turn_until(press - milliseconds(1));
    bench.machine.change(press, by_key ? Input::key : Input::estop, !by_key);
    if (i % 4 < 2) bench.hang_for(milliseconds(3));
    bench.turn_for(milliseconds(30));
    CHECK_TRUE(all_low(bench));
    CHECK_TRUE(last_change(bench) > press - milliseconds(2));
    CHECK_TRUE(last_change(bench) <= press + microseconds(1));
    const fs::Status status = bench.ask(fs::to_frame(Request::beat));
    LONGS_EQUAL(Phase::cut, status.phase);
    LONGS_EQUAL(by_key ? CutCause::key : CutCause::estop, status.cut);
    CHECK_TRUE(status.played[1] > 0 && status.played[1] < flashes.size());
    LONGS_EQUAL(0, status.outputs);
    // It stays so when key and e-stop allow again.
    bench.machine.change(bench.machine.at(), by_key ? Input::key : Input::estop, by_key);
    bench.turn_for(milliseconds(50));
    CHECK_TRUE(last_change(bench) <= press + microseconds(1));
  }
}

TEST(Rp1Hardware, AShortGlitchOfKeyOrEstopCutsNothing) {
  Bench bench;
  bench.get_ready();
  const MonoTime begin = bench.begin(long_shutter, flashes, milliseconds(30));
  for (int i = 0; i < 100; ++i) {
    const MonoTime at = begin + i * microseconds(500);
    bench.machine.change(at, Input::key, false);
    bench.machine.change(at + nanoseconds(300), Input::key, true);
  }
  const fs::Status status = bench.play();
  LONGS_EQUAL(CutCause::none, status.cut);
  check_edges(bench, fs::Track::lamps, flashes);
}

TEST(Rp1Hardware, OutputsAreLow20MsAfterTheLastBeat) {
  Bench bench;
  bench.get_ready();
  const MonoTime begin = bench.begin(long_shutter, flashes, milliseconds(30));
  bench.turn_until(begin + milliseconds(10));
  bench.beats = false;
  const MonoTime stopped = bench.machine.at();
  bench.turn_for(milliseconds(40));
  CHECK_TRUE(all_low(bench));
  CHECK_TRUE(last_change(bench) <= stopped + milliseconds(20));
  LONGS_EQUAL(CutCause::heartbeat, bench.ask(fs::to_frame(Request::beat)).cut);
}

TEST(Rp1Hardware, OutputsAreLow20MsAfterTheThreadHasDied) {
  std::mt19937 random(12);
  for (int i = 0; i < 30; ++i) {
    Bench bench(-50e-6, random());
    bench.get_ready();
    const MonoTime begin = bench.begin(long_shutter, flashes, milliseconds(30));
    bench.turn_until(begin + bench.machine.draw({}, milliseconds(40)));
    const MonoTime died = bench.machine.at();
    bench.hang_for(milliseconds(200));
    CHECK_TRUE(all_low(bench));
    CHECK_TRUE(last_change(bench) <= died + milliseconds(20));
    bench.turn();
    LONGS_EQUAL(CutCause::heartbeat, bench.ask(fs::to_frame(Request::beat)).cut);
  }
}

TEST(Rp1Hardware, AGuardianCutsFromOutside) {
  Bench bench;
  bench.get_ready();
  const MonoTime begin = bench.begin(long_shutter, flashes, milliseconds(30));
  bench.turn_until(begin + milliseconds(20));
  CHECK_TRUE(firmware::cut_outputs(bench.block()));
  const MonoTime cut = bench.machine.at();
  bench.hang_for(milliseconds(100));
  CHECK_TRUE(all_low(bench));
  CHECK_TRUE(last_change(bench) <= cut);
}

TEST(Rp1Hardware, ACutThatTheBlockDidNotHearIsRepeated) {
  Bench bench;
  bench.get_ready();
  const MonoTime begin = bench.begin(long_shutter, flashes, milliseconds(30));
  bench.turn_until(begin + milliseconds(20));
  bench.block().gone = true;
  bench.ask(fs::to_frame(Request::abort));
  const MonoTime asked = bench.machine.at();
  bench.turn_for(milliseconds(3));
  bench.block().gone = false;
  bench.turn_for(milliseconds(30));
  CHECK_TRUE(all_low(bench));
  CHECK_TRUE(last_change(bench) > asked + milliseconds(2));
  CHECK_TRUE(last_change(bench) < asked + milliseconds(7));  // long before the watchers do
}

TEST(Rp1Hardware, OutputsAreNotReleasedWhileKeyOrEstopForbid) {
  for (const bool by_key : {false, true}) {
    Bench bench;
    bench.machine.change(bench.machine.at(), by_key ? Input::key : Input::estop, !by_key);
    bench.turn_for(milliseconds(5));
    CHECK_FALSE(bench.hardware.release());
    bench.machine.change(bench.machine.at(), by_key ? Input::key : Input::estop, by_key);
    bench.turn_for(milliseconds(5));
    CHECK_TRUE(bench.hardware.release());
  }
}

TEST(Rp1Hardware, KeyAndEstopThatCannotBeReadForbid) {
  Bench bench;
  LONGS_EQUAL(fs::bit(InputLine::key), bench.hardware.inputs());
  bench.machine.unreadable = true;
  LONGS_EQUAL(fs::bit(InputLine::estop), bench.hardware.inputs());
}

// ---- stalls ----

TEST(Rp1Hardware, AThreadThatStallsFor15MsLosesNothing) {
  std::mt19937 random(13);
  for (int i = 0; i < 30; ++i) {
    Bench bench(40e-6, random());
    bench.get_ready();
    bench.turn_for(milliseconds(2000));
    const MonoTime asked = bench.begin(long_shutter, flashes, milliseconds(60));
    if (i % 3 == 0) {
      bench.block().stall = milliseconds(15);
    } else {
      bench.turn_until(asked - milliseconds(45) + bench.machine.draw({}, milliseconds(100)));
      bench.machine.stall = milliseconds(15);
    }
    const fs::Status status = bench.play();
    LONGS_EQUAL(CutCause::none, status.cut);
    check_edges(bench, fs::Track::movers, long_shutter);
    check_edges(bench, fs::Track::lamps, flashes);
    // Tried again until the call took 30 us at most, half of it either way.
    CHECK_TRUE(bench.hardware.clocks().start_within <= microseconds(16));
    DOUBLES_EQUAL(static_cast<double>(to_ns(asked)), static_cast<double>(status.started * kTick_ns), 20e3);
    const auto within = static_cast<double>(bench.hardware.clocks().start_within.count()) + 13.0;
    DOUBLES_EQUAL(0.0, begin_error_ns(bench, fs::Track::movers, long_shutter, status.started), within + 1e6 * 60e-6);
  }
}

TEST(Rp1Hardware, ATrainThatCouldNotBeginInTimeIsCutBeforeItsFirstEdge) {
  std::mt19937 random(14);
  for (int i = 0; i < 60; ++i) {
    Bench bench(0.0, random());
    bench.get_ready();
    bench.begin(pulses(0, 1, milliseconds(8), milliseconds(1), {}), flashes, milliseconds(2));
    if (i % 2 == 0) bench.block().stall = milliseconds(4);
    else bench.machine.stall = milliseconds(4);
    const fs::Status status = bench.play();
    LONGS_EQUAL(CutCause::underrun, status.cut);
    CHECK_EQUAL(0, status.played[0] + status.played[1]);
    CHECK_TRUE(bench.block().pins.empty());
  }
}

TEST(Rp1Hardware, EdgesThatTheDmaBringsTooLateAreTold) {
  Bench bench;
  bench.get_ready();
  bench.block().dma_word = microseconds(2);
  bench.begin({}, pulses(2, 100, milliseconds(1), microseconds(1), microseconds(1)), milliseconds(40));
  LONGS_EQUAL(CutCause::underrun, bench.play().cut);
}

TEST(Rp1Hardware, AnOutputStaysOnForTwoMillisecondsAtMostWhereEdgesDoNotCome) {
  Bench bench;
  bench.get_ready();
  const MonoTime begin = bench.begin(long_shutter, flashes, milliseconds(30));
  bench.turn_until(begin + milliseconds(10));
  bench.block().dma_word = milliseconds(1000);
  LONGS_EQUAL(CutCause::underrun, bench.play().cut);
  CHECK_TRUE(all_low(bench));
  // Eight words are queued and two are in the machine: 2.5 ms of flashes. Then two looks .4 ms apart, each a turn of .8 ms
  // and calls later at most.
  CHECK_TRUE(last_change(bench) < begin + milliseconds(10) + microseconds(2500 + 2000));
}

TEST(Rp1Hardware, NothingOfATrainThatWasCutIsPlayedInTheNext) {
  std::mt19937 random(21);
  for (int i = 0; i < 20; ++i) {
    Bench bench(0.0, random());
    bench.get_ready();
    const MonoTime begin = bench.begin(long_shutter, flashes, milliseconds(30));
    bench.turn_until(begin + bench.machine.draw({}, milliseconds(45)));
    bench.carry_out(fs::to_frame(Request::abort));
    bench.turn_for(milliseconds(5));
    bench.carry_out(fs::to_frame(Request::reset));
    const auto others = pulses(3, 5, milliseconds(1), microseconds(300), microseconds(500));
    bench.begin({}, others, milliseconds(30));
    LONGS_EQUAL(CutCause::none, bench.play().cut);
    check_edges(bench, fs::Track::lamps, others);
  }
}

TEST(Rp1Hardware, ADelayThatTheMachineCannotCountIsNotPlayed) {
  Bench bench;
  bench.get_ready();
  bench.carry_out(fs::to_frame(fs::Limits{{100'000'000, 100'000'000, 100'000'000, 100'000'000, 0, 0}}));
  bench.begin(pulses(0, 1, milliseconds(1), milliseconds(25'000), {}), flashes, milliseconds(30));
  LONGS_EQUAL(CutCause::underrun, bench.play().cut);
  CHECK_TRUE(bench.block().pins.empty());
}

TEST(Rp1Hardware, TheDriftIsMeasuredOnAfterAnArmingThatExpired) {
  Bench bench(40e-6);
  bench.get_ready();
  bench.load(fs::Track::movers, long_shutter);
  bench.load(fs::Track::lamps, flashes);
  bench.carry_out(fs::to_frame(fs::Arm{{2, 100}, fs::train_crc(long_shutter, flashes), 0}));
  bench.turn_for(milliseconds(4000));  // it expires after one second
  LONGS_EQUAL(Phase::idle, bench.controller->phase());
  CHECK_TRUE(bench.hardware.clocks().drift_sd < 5e-6);
}

// ---- the gate ----

TEST(Rp1Hardware, AGatedBurstBeginsAtTheGatesEdge) {
  std::mt19937 random(15);
  for (int i = 0; i < 40; ++i) {
    const double drift = std::uniform_real_distribution<double>(-50e-6, 50e-6)(random);
    Bench bench(drift, random());
    bench.get_ready();
    bench.turn_for(milliseconds(1000));
    const auto burst = drawn_edges(random, 2, 40, microseconds(300));
    const MonoTime asked =
        bench.begin(long_shutter, burst, milliseconds(40), std::pair{milliseconds(5), milliseconds(30)});
    const MonoTime gate = asked + milliseconds(7) + bench.machine.draw({}, milliseconds(20));
    // The first one is too early; the third one is in the burst.
    for (const MonoTime edge : {asked + milliseconds(2), gate, gate + microseconds(20)}) {
      bench.machine.change(edge, Input::gate, true);
      bench.machine.change(edge + microseconds(10), Input::gate, false);
    }
    const fs::Status status = bench.play();
    LONGS_EQUAL(CutCause::none, status.cut);
    CHECK_EQUAL(burst.size(), status.played[1]);
    check_edges(bench, fs::Track::movers, long_shutter);
    check_edges(bench, fs::Track::lamps, burst);
    // The block's cycle in which the gate changed, and the drift of a first delay of 2.4 ms at most.
    const std::int64_t cycles = seen(bench, fs::Track::lamps).front().cycle - bench.block().cycle_of(gate);
    DOUBLES_EQUAL(burst.front().delay * 8.0 / 5.0 / (1.0 + bench.hardware.clocks().drift), static_cast<double>(cycles), 2.0);
    // The kernel's stamp of that edge, 1 to 9 us late.
    const std::int64_t late_ns = status.burst_started * kTick_ns - to_ns(gate);
    CHECK_TRUE(late_ns >= 1000 - kTick_ns && late_ns <= 9000);
  }
}

TEST(Rp1Hardware, AnEdgeWhileTheWindowOpensIsToldAsTheBurstIfItWas) {
  std::mt19937 random(19);
  int first = 0, second = 0;
  for (int i = 0; i < 200; ++i) {
    Bench bench(0.0, random());
    bench.get_ready();
    const MonoTime asked =
        bench.begin(long_shutter, flashes, milliseconds(40), std::pair{milliseconds(5), milliseconds(30)});
    // The loop comes round in 0.8 ms, and its calls take up to 30 us each.
    std::array<MonoTime, 2> gate{asked + milliseconds(5) + bench.machine.draw({}, microseconds(1000))};
    gate[1] = gate[0] + microseconds(100);
    for (const MonoTime edge : gate) {
      bench.machine.change(edge, Input::gate, true);
      bench.machine.change(edge + microseconds(10), Input::gate, false);
    }
    const fs::Status status = bench.play();
    LONGS_EQUAL(CutCause::none, status.cut);
    const std::vector<Seen> burst = seen(bench, fs::Track::lamps);
    if (burst.empty()) continue;
    const MonoTime began = bench.block().time_of(burst.front().cycle) - milliseconds(2);
    (began < gate[1] - microseconds(5) ? first : second) += 1;
    const std::int64_t late_ns = status.burst_started * kTick_ns - to_ns(began);
    CHECK_TRUE(late_ns >= 500 && late_ns <= 10'000);
  }
  CHECK_TRUE(first > 20 && second > 5);
}

TEST(Rp1Hardware, AnEdgeWhileTheWindowClosesLeavesNoOutputOn) {
  std::mt19937 random(20);
  const auto burst = pulses(2, 10, nanoseconds(128), milliseconds(1), milliseconds(1));
  int whole = 0, none = 0;
  for (int i = 0; i < 200; ++i) {
    Bench bench(0.0, random());
    bench.get_ready();
    const MonoTime asked =
        bench.begin(long_shutter, burst, milliseconds(40), std::pair{milliseconds(5), milliseconds(30)});
    // As above.
    const MonoTime gate = asked + milliseconds(30) + bench.machine.draw({}, microseconds(1000));
    bench.machine.change(gate, Input::gate, true);
    const fs::Status status = bench.play();
    LONGS_EQUAL(CutCause::none, status.cut);
    if (status.played[1] != 0) {
      check_edges(bench, fs::Track::lamps, burst);
      ++whole;
      continue;
    }
    ++none;
    const std::vector<Seen> edges = seen(bench, fs::Track::lamps);
    CHECK_TRUE(edges.empty() || (edges.size() == 2 && edges.back().levels == 0));
  }
  CHECK_TRUE(whole > 5 && none > 20);
}

TEST(Rp1Hardware, AGateOutsideOfItsWindowStartsNothing) {
  Bench bench;
  bench.get_ready();
  const MonoTime asked =
      bench.begin(long_shutter, flashes, milliseconds(40), std::pair{milliseconds(5), milliseconds(30)});
  for (const Duration after : {milliseconds(4), milliseconds(34)}) {
    bench.machine.change(asked + after, Input::gate, true);
    bench.machine.change(asked + after + milliseconds(2), Input::gate, false);
  }
  const fs::Status status = bench.play();
  LONGS_EQUAL(CutCause::none, status.cut);
  CHECK_EQUAL(2, status.played[0]);
  CHECK_EQUAL(0, status.played[1]);
  CHECK_TRUE(status.burst_started == fs::kNoTicks);
  CHECK_TRUE(seen(bench, fs::Track::lamps).empty());
}

// ---- clocks ----

TEST(Rp1Hardware, TheBlocksDriftIsMeasuredAndTakenOut) {
  std::mt19937 random(16);
  for (const double drift : {-50e-6, -7e-6, 0.0, 50e-6}) {
    Bench bench(drift, random());
    DOUBLES_EQUAL(60e-6, bench.hardware.clocks().drift_sd, 1e-9);
    bench.get_ready();
    bench.turn_for(milliseconds(5000));
    const auto clocks = bench.hardware.clocks();
    CHECK_TRUE(clocks.drift_sd < 1e-6);
    DOUBLES_EQUAL(drift, clocks.drift, 4.0 * clocks.drift_sd);
    bench.begin(pulses(0, 50, milliseconds(2), milliseconds(1), milliseconds(19)), {}, milliseconds(60));
    LONGS_EQUAL(CutCause::none, bench.play().cut);
    const std::vector<Seen> edges = seen(bench, fs::Track::movers);
    const Duration length = bench.block().time_of(edges.back().cycle) - bench.block().time_of(edges.front().cycle);
    DOUBLES_EQUAL(49 * 20e6 + 1e6, static_cast<double>(length.count()), 4.0 * clocks.drift_sd * 1e9 + 6.0);

    // Nothing of before the train, nor of a count that failed, is mixed with what is counted now.
    bench.flaky.share = 0.05;
    bench.turn_for(milliseconds(1000));
    bench.flaky.share = 0.0;
    bench.turn_for(milliseconds(10'000));
    DOUBLES_EQUAL(drift, bench.hardware.clocks().drift, 4.0 * bench.hardware.clocks().drift_sd);
    CHECK_TRUE(bench.hardware.clocks().drift_sd < 0.2e-6);  // it would have aged by as much
  }
}

TEST(Rp1Hardware, ADriftIsWithinFourStandardDeviationsHoweverShortItWasMeasured) {
  std::mt19937 random(22);
  for (int i = 0; i < 150; ++i) {
    const double drift = std::uniform_real_distribution<double>(-50e-6, 50e-6)(random);
    Bench bench(drift, random());
    bench.turn_for((i % 10 + 3) * milliseconds(100) + (i % 15 == 0 ? milliseconds(1000) : Duration{}));
    DOUBLES_EQUAL(drift, bench.hardware.clocks().drift, 4.0 * bench.hardware.clocks().drift_sd);
  }
}

TEST(Rp1Hardware, ADriftThatIsNoLongerMeasuredIsKnownLessAndLess) {
  Bench bench;
  bench.turn_for(milliseconds(5000));
  const double before = bench.hardware.clocks().drift_sd;
  bench.block().gone = true;
  bench.turn_for(milliseconds(10'000));
  CHECK_TRUE(bench.hardware.clocks().drift_sd > before + 0.1e-6);
  CHECK_TRUE(bench.hardware.clocks().drift_sd < 60e-6);
}

TEST(Rp1Hardware, AClockThatNtpSteersAbortsNoTrain) {
  Bench bench;
  bench.get_ready();
  bench.turn_for(milliseconds(5000));
  bench.begin(pulses(0, 50, milliseconds(2), milliseconds(1), milliseconds(39)), flashes, milliseconds(60));
  bench.block().steer(23e-6 + 90e-6);
  LONGS_EQUAL(CutCause::none, bench.play().cut);
}

// ---- a block that does not obey ----

TEST(Rp1Hardware, OutputsOfABlockThatIsGoneAreLowWithin20Ms) {
  Bench bench;
  bench.get_ready();
  const MonoTime begin = bench.begin(long_shutter, flashes, milliseconds(30));
  bench.turn_until(begin + milliseconds(10));
  bench.block().gone = true;
  const MonoTime gone = bench.machine.at();
  bench.turn_for(milliseconds(100));
  CHECK_TRUE(all_low(bench));
  CHECK_TRUE(last_change(bench) <= gone + milliseconds(20));
  const fs::Status status = bench.ask(fs::to_frame(Request::beat));
  LONGS_EQUAL(CutCause::heartbeat, status.cut);
  CHECK_TRUE(status.outputs != 0);  // nobody can say that they are low

  bench.block().gone = false;
  bench.turn_for(milliseconds(20));
  bench.carry_out(fs::to_frame(Request::reset));
  bench.begin(long_shutter, flashes, milliseconds(30));
  LONGS_EQUAL(CutCause::none, bench.play().cut);
  check_edges(bench, fs::Track::lamps, flashes);
}

TEST(Rp1Hardware, WhateverAFlakyBlockDoesOnlyATrainThatPlaysHasOutputsOn) {
  std::mt19937 random(18);
  int whole = 0, cut = 0;
  for (int i = 0; i < 150; ++i) {
    Bench bench(10e-6, random());
    bench.get_ready();
    bench.begin(long_shutter, flashes, milliseconds(30));
    bench.flaky.share = std::pow(10.0, -1.0 - 0.5 * (i % 5));
    (void)bench.play();
    const MonoTime over = bench.machine.at();
    bench.turn_for(milliseconds(50));
    bench.flaky.share = 0.0;
    bench.turn_for(milliseconds(50));
    CHECK_TRUE(all_low(bench));
    if (!bench.block().pins.empty()) CHECK_TRUE(last_change(bench) <= over + milliseconds(20));
    if (bench.ask(fs::to_frame(Request::beat)).cut == CutCause::none) {
      check_edges(bench, fs::Track::movers, long_shutter);
      check_edges(bench, fs::Track::lamps, flashes);
      ++whole;
    } else {
      bench.carry_out(fs::to_frame(Request::reset));
      ++cut;
    }
  }
  CHECK_TRUE(whole > 20 && cut > 20);
}
