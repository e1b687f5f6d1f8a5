// What every way to play a shot's pulses must do: each case runs on pulses timed by software, on those of a flash
// sequencer, and on those of a Raspberry Pi 5's PIO. What the pins did is what the benches recorded, not what the outputs told.
#include "firmware/ports/scheduled_outputs.hpp"

#include <memory>
#include <string>

#include "firmware/core/pulse_schedule.hpp"
#include "firmware/core/timed_outputs.hpp"
#include "tests/firmware/flash_sequencer_bench.hpp"
#include "tests/firmware/rp1_bench.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::testing;

namespace {

struct Pin {
  MonoTime time;
  Output output;
  bool active;
};

struct Bench {
  virtual ~Bench() = default;
  virtual ScheduledOutputs& outputs() = 0;
  virtual Clock& clock() = 0;
  virtual EdgeSource& edges() = 0;
  virtual void interrupt_gate(MonoTime at) = 0;
  /// In order of time; lamps of which both flash are one.
  virtual std::vector<Pin> pins() = 0;
  /// How far what is told may be from what the pins did.
  virtual Duration told_within() const = 0;
  /// How far the pins may be from what was planned.
  virtual Duration planned_within() const = 0;
  /// From cut() until all pins are inactive.
  virtual Duration cut_within() const = 0;
};

struct TimedBench final : Bench {
  Rig config = shipped_rig();
  VirtualRig rig;
  TimedOutputs timed{config, rig, rig};
  ScheduledOutputs& outputs() override { return timed; }
  Clock& clock() override { return rig; }
  EdgeSource& edges() override { return rig; }
  void interrupt_gate(MonoTime at) override { rig.schedule({Input::gate, at, true}); }
  std::vector<Pin> pins() override {
    std::vector<Pin> pins;
    std::array<bool, 3> level{};
    for (const VirtualRig::Set& set : rig.sets) {
      if (level[index_of(set.output)] == set.active) continue;
      level[index_of(set.output)] = set.active;
      pins.push_back({set.time, set.output, set.active});
    }
    return pins;
  }
  Duration told_within() const override { return rig.set_cost; }  // the line changes somewhere within the call
  // Another pulse may be being set, and the clock read, when the instant comes; an end counts from the begin's.
  Duration planned_within() const override { return microseconds(2); }
  Duration cut_within() const override { return microseconds(2); }  // three calls
};

struct SequencerBench final : Bench {
  FlashSequencerBench bench;
  SequencerBench() {
    CHECK_TRUE_TEXT(bench.connected.has_value(), bench.connected ? "" : bench.connected.error().message.c_str());
    while (bench.line.time < from_ns(8'000'000'000)) {  // the clocks are related by four seconds
      std::array<Edge, 8> edges;
      bench.inputs.wait(bench.line.time + milliseconds(50), edges);
    }
  }
  ScheduledOutputs& outputs() override { return bench.outputs; }
  Clock& clock() override { return bench.line; }
  EdgeSource& edges() override { return bench.inputs; }
  void interrupt_gate(MonoTime at) override { bench.line.schedule(at, flash_sequencer::InputLine::gate, true); }
  std::vector<Pin> pins() override {
    std::vector<Pin> pins;
    for (const PinChange& pin : bench.line.chip.pins) {
      if (pin.line == flash_sequencer::OutputLine::strobe_b) continue;  // all flashes here are of both
      pins.push_back({pin.time,
                      pin.line == flash_sequencer::OutputLine::shutter   ? Output::shutter
                      : pin.line == flash_sequencer::OutputLine::trigger ? Output::trigger
                                                                         : Output::strobes,
                      pin.active});
    }
    return pins;
  }
  // Of 15 beats in a quarter of a second the best bounds are off by 0.07 us of 1 us in the mean; the line's stop bit of
  // 0.01 us, a tick of 0.008 us and the drift's rest over a shot are less. The bound of a stamp's own deviation is 0.3 us.
  Duration told_within() const override { return microseconds(1); }
  Duration planned_within() const override { return microseconds(1); }
  Duration cut_within() const override { return microseconds(500); }  // a frame, and what is on its way before it
};

struct PioBench final : Bench {
  Rp1Bench bench;
  PioBench() {
    CHECK_TRUE(bench.taken);
    CHECK_TRUE_TEXT(bench.connected.has_value(), bench.connected ? "" : bench.connected.error().message.c_str());
    while (bench.rp1.time < from_ns(8'000'000'000)) {
      std::array<Edge, 8> edges;
      bench.inputs.wait(bench.rp1.time + milliseconds(50), edges);
    }
  }
  ScheduledOutputs& outputs() override { return bench.outputs; }
  Clock& clock() override { return bench.rp1; }
  EdgeSource& edges() override { return bench.inputs; }
  void interrupt_gate(MonoTime at) override { bench.rp1.schedule(at, rp1_pin::gate, true); }
  std::vector<Pin> pins() override {
    bench.rp1.block.advance();
    std::vector<Pin> pins;
    for (const SimulatedPioBlock::PinChange& pin : bench.rp1.block.pins) {
      if (pin.pin == rp1_pin::strobe_b) continue;  // all flashes here are of both
      pins.push_back({pin.time,
                      pin.pin == rp1_pin::shutter   ? Output::shutter
                      : pin.pin == rp1_pin::trigger ? Output::trigger
                                            : Output::strobes,
                      pin.level});
    }
    return pins;
  }
  // The call that starts the train took at most 30 us: what is told is its middle. A gate's stamp is up to 5 us late. The
  // drift's rest over a shot and the clocks' relation are less than 1 us.
  Duration told_within() const override { return microseconds(16); }
  Duration planned_within() const override { return microseconds(17); }  // and the start is aimed at the middle
  // Whoever asks wakes the sequencer's thread after 10 us; calls of 30 us each: two that feed the watchers and are under
  // way, two that cut.
  Duration cut_within() const override { return microseconds(200); }
};

/// Keeps all that is told, and says no to what it is asked to.
struct Recorder final : ScheduledOutputs::Listener {
  struct Told {
    Output output;
    bool on;
    Issue issue;
    PlannedPulse pulse;
    Duration on_time;
  };
  ScheduledOutputs& outputs;
  std::vector<Told> told;
  std::vector<PlannedPulse> asked;
  std::string failure;
  MonoTime late_for = kNoTime;
  bool allows_trigger = true;

  explicit Recorder(ScheduledOutputs& from) : outputs(from) { told.reserve(4000); }
  bool allows(const PlannedPulse& pulse, MonoTime) noexcept override {
    asked.push_back(pulse);
    if (pulse.output != Output::trigger || allows_trigger) return true;
    outputs.cut();
    return false;
  }
  void switched_on(const PlannedPulse& pulse, const Issue& issue) noexcept override {
    told.push_back({pulse.output, true, issue, pulse, {}});
  }
  void switched_off(Output output, const Issue& issue, Duration on_time) noexcept override {
    told.push_back({output, false, issue, {}, on_time});
  }
  void failed(const ShortText& why, MonoTime late) noexcept override {
    if (failure.empty()) {
      failure = why.view();
      late_for = late;
    }
    outputs.cut();
  }
  std::vector<Told> ons() const {
    std::vector<Told> ons;
    for (const Told& each : told)
      if (each.on) ons.push_back(each);
    return ons;
  }
};

/// A shot on a bench.
struct Shot {
  Bench& bench;
  Recorder told{bench.outputs()};
  ShotPlan plan;
  PulseSchedule schedule;
  MonoTime start;

  explicit Shot(Bench& on, const Rig& rig = shipped_rig()) : bench(on), plan(rig.plan) {
    schedule.reserve(rig.lamps.max_flashes);
  }
  void build(const Rig& rig = shipped_rig()) { build_schedule(plan, rig, schedule); }
  void begin() { begin_at(bench.clock().now() + std::max<Duration>(milliseconds(20), bench.outputs().lead(schedule))); }
  void begin_at(MonoTime at) {
    start = at;
    bench.outputs().begin(schedule, start, told);
  }
  /// As the loop turns.
  void turn_until(MonoTime end) {
    std::array<Edge, 64> edges;
    while (bench.clock().now() < end) {
      const MonoTime due = bench.outputs().next_due();
      const MonoTime wake = std::min(end, due == kNoDeadline ? bench.clock().now() + milliseconds(50)
                                                             : due - shipped_rig().tolerance.spin);
      const auto count = bench.edges().wait(wake, edges);
      for (std::size_t i = 0; i < count.value_or(0); ++i) {
        if (edges[i].input == Input::gate && schedule.gated && told.failure.empty()) gate(edges[i].time);
      }
      bench.outputs().run(told);
      bench.outputs().take_failure();
    }
  }
  void gate(MonoTime at) {
    const std::size_t first = schedule.pulses.size();
    CHECK(add_burst(plan, shipped_rig(), at + plan.gate_delay - start, schedule));
    bench.outputs().add(first);
  }
  void play() { turn_until(start + schedule.exposure_end + milliseconds(60)); }
};

/// Runs a case on each bench.
template <typename Case>
void on_each(Case&& run) {
  TimedBench timed;
  run(static_cast<Bench&>(timed));
  SequencerBench sequencer;
  run(static_cast<Bench&>(sequencer));
  PioBench pio;
  run(static_cast<Bench&>(pio));
}

bool within(Duration limit, MonoTime one, MonoTime other) { return one - other <= limit && other - one <= limit; }

void check_all_over(Bench& bench) {
  CHECK_FALSE(bench.outputs().any_active());
  CHECK_FALSE(bench.outputs().broken());
  CHECK(bench.outputs().all_issued());
}

}  // namespace

TEST_GROUP(ScheduledOutputs){};

TEST(ScheduledOutputs, TellEveryPulseOnceInOrderWithItsInstant) {
  on_each([](Bench& bench) {
    Shot shot(bench);
    shot.build();
    shot.begin();
    shot.play();
    CHECK_EQUAL(std::string(), shot.told.failure);
    const auto ons = shot.told.ons();
    CHECK_EQUAL(shot.schedule.pulses.size(), ons.size());
    for (std::size_t i = 0; i < ons.size(); ++i) {
      const PlannedPulse& planned = shot.schedule.pulses[i];
      CHECK_EQUAL(planned.output, ons[i].output);
      CHECK_EQUAL(planned.flash_index, ons[i].pulse.flash_index);
      CHECK_EQUAL(shot.start + planned.at, ons[i].issue.commanded);
      CHECK(ons[i].issue.done && ons[i].issue.start <= ons[i].issue.end);
      CHECK(within(bench.planned_within(), ons[i].issue.start, shot.start + planned.at));
    }
    for (std::size_t i = 1; i < shot.told.told.size(); ++i)
      CHECK(shot.told.told[i].issue.start >= shot.told.told[i - 1].issue.start);
    check_all_over(bench);
  });
}

TEST(ScheduledOutputs, TellWhatThePinsDid) {
  on_each([](Bench& bench) {
    Shot shot(bench);
    shot.build();
    shot.begin();
    shot.play();
    const auto pins = bench.pins();
    CHECK_EQUAL(2 * shot.schedule.pulses.size(), pins.size());
    CHECK_EQUAL(pins.size(), shot.told.told.size());
    for (std::size_t i = 0; i < pins.size(); ++i) {
      const auto& told = shot.told.told[i];
      CHECK_EQUAL(pins[i].output, told.output);
      CHECK_EQUAL(pins[i].active, told.on);
      CHECK(pins[i].time >= told.issue.start - bench.told_within());
      CHECK(pins[i].time <= told.issue.end + bench.told_within());
    }
  });
}

TEST(ScheduledOutputs, AreOffAfterTheirWidth) {
  on_each([](Bench& bench) {
    Shot shot(bench);
    shot.build();
    shot.begin();
    shot.play();
    std::array<MonoTime, 3> on_at{};
    std::array<Duration, 3> width{};
    for (const auto& told : shot.told.told) {
      const std::size_t output = index_of(told.output);
      if (told.on) {
        on_at[output] = told.issue.start;
        width[output] = told.pulse.width;
      } else {
        CHECK(within(bench.planned_within(), told.issue.end, on_at[output] + width[output]));
        CHECK(within(bench.planned_within(), MonoTime{told.on_time}, MonoTime{width[output]}));
      }
    }
  });
}

TEST(ScheduledOutputs, AreOnForNoLongerThanTheRigsLongestTime) {
  on_each([](Bench& bench) {
    Shot shot(bench);
    shot.build();
    for (PlannedPulse& pulse : shot.schedule.pulses)
      if (pulse.output == Output::strobes) pulse.width = 3 * shipped_rig().lamps.max_on;
    shot.begin();
    shot.play();
    CHECK_EQUAL(std::string(), shot.told.failure);
    MonoTime on_at;
    int flashes = 0;
    for (const Pin& pin : bench.pins()) {
      if (pin.output != Output::strobes) continue;
      if (pin.active) on_at = pin.time;
      if (pin.active) continue;
      CHECK(pin.time - on_at <= shipped_rig().lamps.max_on + bench.planned_within());
      ++flashes;
    }
    CHECK_EQUAL(shot.schedule.flash_count, flashes);
  });
}

TEST(ScheduledOutputs, AreInactiveOnceCutAndStaySo) {
  on_each([](Bench& bench) {
    Shot shot(bench);
    shot.build();
    shot.begin();
    shot.turn_until(shot.start + shot.schedule.exposure_begin + milliseconds(100));
    CHECK(bench.outputs().active(Output::shutter));
    CHECK_FALSE(bench.outputs().active(Output::trigger));
    CHECK(bench.outputs().cut());
    const MonoTime cut = bench.clock().now();
    shot.play();
    const auto pins = bench.pins();
    CHECK(pins.back().time <= cut + bench.cut_within());
    CHECK_FALSE(pins.back().active);
    int active = 0;
    for (const Pin& pin : pins) active += pin.active ? 1 : -1;
    CHECK_EQUAL(0, active);
    // What was played before was told, and nothing else.
    std::size_t played = 0;
    for (const Pin& pin : pins) played += pin.active ? 1 : 0;
    CHECK_EQUAL(played, shot.told.ons().size());
    check_all_over(bench);
  });
}

TEST(ScheduledOutputs, PlayTheNextShotAfterACut) {
  on_each([](Bench& bench) {
    Shot first(bench);
    first.build();
    first.begin();
    first.turn_until(first.start + milliseconds(80));
    bench.outputs().cut();
    first.turn_until(first.start + milliseconds(200));
    check_all_over(bench);
    Shot second(bench);
    second.build();
    second.begin();
    second.play();
    CHECK_EQUAL(std::string(), second.told.failure);
    CHECK_EQUAL(second.schedule.pulses.size(), second.told.ons().size());
    check_all_over(bench);
  });
}

TEST(ScheduledOutputs, PlayOneShotAfterTheOther) {
  on_each([](Bench& bench) {
    for (int i = 0; i < 3; ++i) {
      Shot shot(bench);
      shot.plan.dry = i == 1;
      shot.plan.period = microseconds(3000 + 250 * i);
      shot.build();
      shot.begin();
      shot.play();
      CHECK_EQUAL(std::string(), shot.told.failure);
      CHECK_EQUAL(shot.schedule.pulses.size(), shot.told.ons().size());
      check_all_over(bench);
    }
  });
}

TEST(ScheduledOutputs, AskForEveryPulseOnce) {
  on_each([](Bench& bench) {
    Shot shot(bench);
    shot.build();
    shot.begin();
    CHECK_TRUE(shot.told.ons().empty());
    shot.play();
    CHECK_EQUAL(shot.schedule.pulses.size(), shot.told.asked.size());
    for (std::size_t i = 0; i < shot.told.asked.size(); ++i)
      CHECK_EQUAL(shot.schedule.pulses[i].at, shot.told.asked[i].at);
  });
}

TEST(ScheduledOutputs, DoNotPullATriggerThatIsNotAllowed) {
  on_each([](Bench& bench) {
    Shot shot(bench);
    shot.build();
    shot.told.allows_trigger = false;
    shot.begin();
    shot.play();
    for (const Pin& pin : bench.pins()) CHECK(pin.output != Output::trigger);
    for (const auto& told : shot.told.told) CHECK(told.output != Output::trigger);
    check_all_over(bench);
  });
}

TEST(ScheduledOutputs, PlayABurstWhenTheGateSaysSo) {
  on_each([](Bench& bench) {
    Shot shot(bench);
    shot.plan.train = Train::gated;
    shot.plan.flash_count = 8;
    shot.plan.gate_delay = microseconds(1500);
    shot.build();
    CHECK_EQUAL(8u, shot.schedule.burst.size());
    shot.begin();
    const MonoTime gate = shot.start + shot.schedule.exposure_begin + microseconds(123'456);
    bench.interrupt_gate(gate);
    shot.play();
    CHECK_EQUAL(std::string(), shot.told.failure);
    const auto ons = shot.told.ons();
    CHECK_EQUAL(shot.schedule.pulses.size(), ons.size());
    int flash = 0;
    for (const auto& on : ons) {
      if (on.output != Output::strobes) continue;
      CHECK_EQUAL(flash, on.pulse.flash_index);
      const MonoTime due = gate + shot.plan.gate_delay + shot.plan.period * flash++;
      CHECK(within(bench.planned_within(), due, on.issue.commanded));
    }
    CHECK_EQUAL(8, flash);
    flash = 0;
    for (const Pin& pin : bench.pins()) {
      if (pin.output != Output::strobes || !pin.active) continue;
      const MonoTime due = gate + shot.plan.gate_delay + shot.plan.period * flash++;
      CHECK(within(bench.planned_within(), due, pin.time));
    }
    CHECK_EQUAL(8, flash);
    check_all_over(bench);
  });
}

TEST(ScheduledOutputs, DoNotFlashWithoutTheGate) {
  on_each([](Bench& bench) {
    Shot shot(bench);
    shot.plan.train = Train::gated;
    shot.plan.flash_count = 8;
    shot.build();
    shot.begin();
    shot.turn_until(shot.start + shot.schedule.exposure_end);
    CHECK(bench.outputs().all_issued());
    bench.outputs().cut();
    shot.play();
    for (const Pin& pin : bench.pins()) CHECK(pin.output != Output::strobes);
    check_all_over(bench);
  });
}

TEST(ScheduledOutputs, FailRatherThanPlayWhatIsTooLate) {
  on_each([](Bench& bench) {
    Shot shot(bench);
    shot.build();
    const MonoTime now = bench.clock().now();
    shot.begin_at(now - milliseconds(5));
    shot.turn_until(now + milliseconds(100));
    CHECK(!shot.told.failure.empty());
    CHECK_EQUAL(shot.start, shot.told.late_for);
    CHECK_TRUE(bench.pins().empty());
    check_all_over(bench);
  });
}

TEST(ScheduledOutputs, HaveNothingToDoBeforeAndAfter) {
  on_each([](Bench& bench) {
    CHECK(bench.outputs().all_issued() && !bench.outputs().any_active());
    CHECK_EQUAL(kNoDeadline, bench.outputs().next_due());
    Shot shot(bench);
    shot.build();
    shot.begin();
    CHECK_FALSE(bench.outputs().all_issued());
    shot.play();
    CHECK_EQUAL(kNoDeadline, bench.outputs().next_due());
  });
}
