// strobed's loop with a flash sequencer at the other end of its line, on a virtual clock.
#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include "firmware/core/sequencer.hpp"
#include "tests/firmware/flash_sequencer_bench.hpp"
#include "tests/support/allocations.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::testing;

namespace {

using flash_sequencer::InputLine;
using flash_sequencer::OutputLine;

/// The loop, whose events and commands a virtual rig keeps.
struct Loop {
  FlashSequencerBench bench;
  VirtualRig keeper{400, 64};
  Sequencer loop;
  std::int64_t last_command = 0;

  explicit Loop(const Rig& rig = shipped_rig())
      : bench(rig), loop(bench.config, {bench.line, bench.outputs, bench.inputs, keeper, keeper}, 0) {
    CHECK_TRUE_TEXT(bench.connected.has_value(), bench.connected ? "" : bench.connected.error().message.c_str());
    keeper.time = MonoTime::max() - milliseconds(1'000'000);  // commands are taken at once
    CHECK(loop.start("test"));
    turn_for(milliseconds(4000));  // until the clocks are well related
  }
  bool turn() { return loop.step(bench.line.time + milliseconds(50)); }
  bool turn_for(Duration duration) {
    bool safe = true;
    for (const MonoTime end = bench.line.time + duration; safe && bench.line.time < end;) safe = turn();
    return safe;
  }
  void queue(CommandKind kind, std::int64_t token = 0) {
    Command command;
    command.kind = kind;
    command.host_id = 77;
    command.command_id = ++last_command;
    command.new_token = 500 + last_command;
    command.token = token;
    command.plan = bench.config.plan;
    command.acted_boot_time = Duration{to_ns(bench.line.time)};
    keeper.schedule_command(MonoTime{}, command);
  }
  void give(CommandKind kind, std::int64_t token = 0) {
    queue(kind, token);
    turn();
  }
  void fire() {
    give(CommandKind::arm);
    give(CommandKind::fire, keeper.statuses.back().arm_token);
    CHECK_EQUAL(State::firing, loop.state());
  }
  bool play() {
    bool safe = true;
    for (const MonoTime end = bench.line.time + milliseconds(10'000);
         safe && loop.state() == State::firing && bench.line.time < end;)
      safe = turn();
    return safe;
  }
  const ShotRecord& shoot() {
    fire();
    CHECK(play());
    return shot();
  }
  /// Fires, and interrupts the gate so long after the shutter is open. Returns when.
  MonoTime interrupt_gate(Duration after_exposure_begin) {
    fire_until(after_exposure_begin - milliseconds(20));
    const MonoTime at = bench.line.time + milliseconds(20);
    bench.line.schedule(at, InputLine::gate, true);
    bench.line.schedule(at + milliseconds(1), InputLine::gate, false);
    return at;
  }
  void fire_until(Duration after_exposure_begin) {
    fire();
    while (!known(record().shutter_on)) turn();
    turn_for(shipped_rig().shutter.lag + after_exposure_begin);
  }
  const ShotRecord& shot() const { return *keeper.shots.back(); }
  /// Of the shot that plays.
  const ShotRecord& record() { return *keeper.free_record(); }
  std::string reason() const { return std::string(shot().abort_reason.view()); }
  std::vector<PinChange> pins(OutputLine line, bool active) const {
    std::vector<PinChange> pins;
    for (const PinChange& pin : bench.line.chip.pins)
      if (pin.line == line && pin.active == active) pins.push_back(pin);
    return pins;
  }
  bool all_inactive() const { return const_cast<VirtualSequencerChip&>(bench.line.chip).outputs() == 0; }
};

Rig gated_rig() {
  Rig rig = shipped_rig();
  rig.plan.train = Train::gated;
  rig.plan.flash_count = 60;
  rig.plan.gate_delay = microseconds(200);
  return rig;
}

std::size_t issued_of(const ShotRecord& shot) {
  return static_cast<std::size_t>(
      std::ranges::count_if(shot.flashes, [](const FlashRecord& flash) { return known(flash.issue_end); }));
}

double us(Duration duration) { return to_microseconds(duration); }

/// What the relation of the clocks is off by (scheduled_outputs_test.cpp).
constexpr double kRelated_us = 1.0;

}  // namespace

TEST_GROUP(FlashSequencer){};

TEST(FlashSequencer, PlaysAShotAsItWasPlanned) {
  Loop rig;
  const ShotRecord& shot = rig.shoot();
  CHECK_EQUAL(std::string(), rig.reason());
  CHECK_EQUAL(1u, rig.keeper.count(EventKind::shot_ended));
  CHECK_EQUAL(1u, rig.keeper.count(EventKind::trigger) / 2);  // on and off
  const auto flashes = rig.pins(OutputLine::strobe_a, true);
  CHECK_EQUAL(shot.flashes.size(), flashes.size());
  CHECK_EQUAL(static_cast<std::size_t>(flash_count(rig.bench.config.plan)), flashes.size());
  for (std::size_t k = 0; k < flashes.size(); ++k) {
    const FlashRecord& flash = shot.flashes[k];
    CHECK_EQUAL(shot.start + milliseconds(60) + rig.bench.config.plan.period * static_cast<std::int64_t>(k),
                flash.commanded);
    DOUBLES_EQUAL(0.0, us(flashes[k].time - flash.commanded), kRelated_us);
    DOUBLES_EQUAL(0.0, us(flash.issue_end - flashes[k].time), kRelated_us);
    DOUBLES_EQUAL(12.0, us(flash.observed_a - flashes[k].time), kRelated_us);
    DOUBLES_EQUAL(12.0, us(flash.observed_b - flashes[k].time), kRelated_us);
    CHECK_EQUAL(0, flash.extra_edges);
  }
  DOUBLES_EQUAL(0.0, us(rig.pins(OutputLine::trigger, true).at(0).time - shot.trigger), kRelated_us);
  DOUBLES_EQUAL(0.0, us(rig.pins(OutputLine::shutter, false).at(0).time - shot.shutter_off), kRelated_us);
  CHECK_EQUAL(0, shot.kernel_overflows);
  CHECK(rig.all_inactive());
}

TEST(FlashSequencer, MindsNoStandstillOfTheLoopsCore) {
  Loop rig;
  for (MonoTime at = rig.bench.line.time; at < rig.bench.line.time + milliseconds(40'000); at += milliseconds(97))
    rig.bench.line.freeze(at, milliseconds(20));
  for (int i = 0; i < 10; ++i) {
    const ShotRecord& shot = rig.shoot();
    CHECK_EQUAL(std::string(), rig.reason());
    for (const FlashRecord& flash : shot.flashes) {
      DOUBLES_EQUAL(0.0, us(flash.issue_end - flash.commanded), kRelated_us);
      DOUBLES_EQUAL(12.0, us(flash.observed_a - flash.issue_end), kRelated_us);
    }
    rig.turn_for(milliseconds(100));
  }
}

TEST(FlashSequencer, IsCutByTheEStopItself) {
  Loop rig;
  rig.fire_until(milliseconds(100));
  const MonoTime pressed = rig.bench.line.time + microseconds(1234);
  rig.bench.line.schedule(pressed, InputLine::estop, true);
  rig.play();
  CHECK_EQUAL(std::string("the e-stop is pressed"), rig.reason());
  CHECK(rig.bench.line.chip.pins.back().time <= pressed);
  CHECK(rig.all_inactive());
  const Event* estop = rig.keeper.find(EventKind::estop, 1);  // after that of the start
  CHECK(estop != nullptr && estop->level == 1);
  DOUBLES_EQUAL(0.0, us(estop->device_time - pressed), kRelated_us);
}

TEST(FlashSequencer, PlaysTheNextShotAfterAnEStop) {
  Loop rig;
  rig.fire_until(milliseconds(100));
  rig.bench.line.schedule(rig.bench.line.time + microseconds(10), InputLine::estop, true);
  rig.bench.line.schedule(rig.bench.line.time + milliseconds(500), InputLine::estop, false);
  rig.turn_for(milliseconds(3000));
  rig.give(CommandKind::reset);
  rig.turn_for(milliseconds(3000));
  rig.shoot();
  CHECK_EQUAL(std::string(), rig.reason());
}

TEST(FlashSequencer, IsCutByADisarm) {
  Loop rig;
  rig.fire_until(milliseconds(100));
  rig.give(CommandKind::disarm);
  const MonoTime given = rig.bench.line.time;
  rig.play();
  CHECK(rig.bench.line.chip.pins.back().time <= given + milliseconds(1));
  CHECK(rig.all_inactive() && !rig.bench.outputs.any_active());
  // Every flash that was, and no other.
  CHECK_EQUAL(rig.pins(OutputLine::strobe_a, true).size(), rig.keeper.count(EventKind::flash));
  DOUBLES_EQUAL(0.0, us(rig.shot().shutter_off - rig.pins(OutputLine::shutter, false).at(0).time), 1000.0);
}

// No output is on yet, but the trigger may come until the sequencer has heard the ABORT.
TEST(FlashSequencer, AStopIsNotOverBeforeTheSequencerSaysThatItHasCut) {
  Loop rig;
  rig.fire();
  while (rig.bench.link.status().phase != flash_sequencer::Phase::playing) rig.turn();
  CHECK_TRUE(rig.bench.line.chip.pins.empty());
  rig.bench.line.answers = false;
  rig.give(CommandKind::disarm);
  rig.turn_for(milliseconds(20));
  CHECK_TRUE(rig.bench.outputs.any_active());
  CHECK_EQUAL(State::firing, rig.loop.state());
  rig.bench.line.answers = true;
  CHECK(rig.play());
  CHECK_FALSE(rig.bench.outputs.any_active());
  CHECK_TRUE(rig.shot().abort_reason.view().find("disarmed") != std::string_view::npos);
}

// The gate's edge is in the status as well.
TEST(FlashSequencer, TellsABurstOfWhoseGateTheReportWasLost) {
  Loop rig(gated_rig());
  rig.bench.line.lose_reports_of(InputLine::gate);
  const MonoTime gate = rig.interrupt_gate(milliseconds(100));
  CHECK(rig.play());
  CHECK_EQUAL(std::string(), rig.reason());
  DOUBLES_EQUAL(0.0, us(rig.shot().gate - gate), kRelated_us);
  CHECK_EQUAL(static_cast<std::size_t>(flash_count(rig.bench.config.plan)), rig.keeper.count(EventKind::flash));
}

// The gate's edge, flashes and the cut may come to the loop at once or one by one, in any order of reports and status.
TEST(FlashSequencer, TellsEachFlashOfABurstThatIsCutWithinMillisecondsOfItsGate) {
  Loop rig(gated_rig());
  for (int k = 0; k < 32; ++k) {
    rig.bench.line.loses = nullptr;
    if (k % 2 == 0) rig.bench.line.lose_reports_of(InputLine::gate);
    const std::size_t before = rig.pins(OutputLine::strobe_a, true).size();
    const MonoTime gate = rig.interrupt_gate(milliseconds(100));
    if (k % 4 < 2) rig.bench.line.freeze(gate - microseconds(100), milliseconds(12));
    const MonoTime pressed = gate + microseconds(250 + 211 * k);
    rig.bench.line.schedule(pressed, InputLine::estop, true);
    rig.bench.line.schedule(pressed + milliseconds(50), InputLine::estop, false);
    CHECK(rig.play());
    CHECK_EQUAL(std::string("the e-stop is pressed"), rig.reason());
    CHECK_EQUAL(rig.pins(OutputLine::strobe_a, true).size() - before, issued_of(rig.shot()));
    DOUBLES_EQUAL(0.0, us(rig.shot().gate - gate), kRelated_us);
    rig.turn_for(milliseconds(100));
    rig.give(CommandKind::reset);
    rig.turn_for(milliseconds(3000));
  }
}

TEST(FlashSequencer, TellsOfAShortPressBetweenShotsWhoseReportsWereLost) {
  for (const InputLine line : {InputLine::estop, InputLine::key}) {
    Loop rig;
    rig.shoot();  // the sequencer is not cut any more
    rig.turn_for(milliseconds(100));
    const EventKind kind = line == InputLine::estop ? EventKind::estop : EventKind::key;
    const std::size_t before = rig.keeper.count(kind);
    rig.bench.line.lose_reports_of(line);
    const bool pressed = line == InputLine::estop;
    rig.bench.line.schedule(rig.bench.line.time + milliseconds(1), line, pressed);
    rig.bench.line.schedule(rig.bench.line.time + milliseconds(2), line, !pressed);
    rig.turn_for(milliseconds(100));
    CHECK_EQUAL(before + 2, rig.keeper.count(kind));
    CHECK_EQUAL(pressed ? 1 : 0, rig.keeper.find(kind, before)->level);
    CHECK_EQUAL(pressed ? 0 : 1, rig.keeper.find(kind, before + 1)->level);
    if (pressed) CHECK_EQUAL(State::stopped, rig.loop.state());
  }
}

TEST(FlashSequencer, ClosesAShotWithoutSpinning) {
  Loop rig;
  rig.fire_until(milliseconds(100));
  rig.bench.line.answers = false;
  rig.give(CommandKind::disarm);
  const std::size_t shots = rig.keeper.shots.size();
  int turns = 0;
  for (const MonoTime end = rig.bench.line.time + milliseconds(80); rig.bench.line.time < end; ++turns) rig.turn();
  // It looks for 0.15 ms before each ABORT, as before a pulse, in turns of 2 us; one that spins turns 37,000 times.
  CHECK_TRUE_TEXT(turns < 80 / 5 * 150, std::to_string(turns).c_str());
  CHECK_EQUAL(shots, rig.keeper.shots.size());
  rig.bench.line.answers = true;
  CHECK(rig.play());
  rig.turn_for(milliseconds(100));
  CHECK_EQUAL(shots + 1, rig.keeper.shots.size());
}

// Whatever it was about to do.
TEST(FlashSequencer, ForgetsNoBounceOfTheEStopWhileAnArmingExpires) {
  using namespace flash_sequencer;
  for (int bounces_after = 0; bounces_after < 8; ++bounces_after) {
    VirtualSequencerChip chip;
    Controller controller(chip, 1, false);
    Limits limits;
    limits.max_on_us.fill(1000);
    std::uint8_t number = 0;
    const auto ask = [&](Frame request) {
      request.number = ++number;
      Frame reply;
      CHECK(controller.answer(request, chip.now(), reply));
      CHECK(read_status(reply)->refusal == Refusal::none);
    };
    ask(to_frame(Request::beat));
    ask(to_frame(Request::reset));
    ask(to_frame(limits));
    Load load;
    load.track = Track::lamps;
    load.count = 2;
    load.edges = {{{100, 4}, {100, 0}}};
    ask(to_frame(load));
    Arm arm;
    arm.edges = {0, 2};
    arm.crc = train_crc({}, std::span(load.edges).first(2));
    ask(to_frame(arm));
    for (int k = 1; k < 251; ++k) {  // almost kArmedFor
      chip.advance(chip.started + milliseconds(4) * k);
      ask(to_frame(Request::beat));
      controller.turn();
    }
    CHECK(controller.phase() == Phase::armed || controller.phase() == Phase::idle);
    chip.advance(chip.started + milliseconds(1004));
    ask(to_frame(Request::beat));
    chip.bounces_after = bounces_after;
    controller.turn();
    const bool bounced = chip.bounces_after < 0;
    chip.bounces_after = -1;
    controller.turn();
    CHECK_TRUE_TEXT(!bounced || controller.phase() == Phase::cut, std::to_string(bounces_after).c_str());
    CHECK(controller.phase() == Phase::cut || controller.phase() == Phase::idle);
  }
}

TEST(FlashSequencer, CutsItselfWhenTheBeatsStop) {
  Loop rig;
  rig.fire_until(milliseconds(100));
  rig.bench.line.beat = nullptr;
  const MonoTime stopped = rig.bench.line.time;
  rig.play();
  // The last beat came 4 ms before, the sequencer waits for 15 ms and looks every 0.5 ms.
  CHECK(rig.bench.line.chip.pins.back().time <= stopped + microseconds(15'500));
  CHECK_FALSE(rig.reason().empty());
  CHECK(rig.all_inactive());
}

TEST(FlashSequencer, SaysThatItWasReset) {
  Loop rig;
  rig.fire_until(milliseconds(100));
  rig.bench.line.boot();
  rig.play();
  CHECK_EQUAL(std::string("the flash sequencer was reset"), rig.reason());
  CHECK_EQUAL(State::fault, rig.loop.state());
  CHECK_EQUAL(std::string("the flash sequencer was reset"), std::string(rig.keeper.find(EventKind::fault)->detail.view()));
  CHECK(rig.all_inactive());
  rig.give(CommandKind::clear);
  rig.turn_for(milliseconds(4000));
  rig.shoot();
  CHECK_EQUAL(std::string(), rig.reason());
}

TEST(FlashSequencer, SaysThatItWasResetBetweenShots) {
  Loop rig;
  rig.bench.line.boot();
  rig.turn_for(milliseconds(20));
  CHECK_EQUAL(State::fault, rig.loop.state());
}

TEST(FlashSequencer, IsNotStartedWhenItCouldNotBeLoadedInTime) {
  Loop rig;
  rig.give(CommandKind::arm);
  rig.bench.line.freeze(rig.bench.line.time + milliseconds(30), milliseconds(150));
  rig.give(CommandKind::fire, rig.keeper.statuses.back().arm_token);
  rig.play();
  CHECK_EQUAL(std::string("the flash sequencer was not loaded in time"), rig.reason());
  CHECK_EQUAL(rig.shot().start, rig.keeper.find(EventKind::shot_aborted)->commanded);
  CHECK_TRUE(rig.bench.line.chip.pins.empty());
}

TEST(FlashSequencer, EndsTheLoopIfItDoesNotSayThatItIsCut) {
  Loop rig;
  rig.fire_until(milliseconds(100));
  rig.bench.line.answers = false;
  const MonoTime silent = rig.bench.line.time;
  CHECK_FALSE(rig.turn_for(milliseconds(1000)));
  CHECK(rig.bench.outputs.broken() && rig.bench.outputs.any_active());
  // Until the silence is taken for one, until the cut is not believed in any more, and a turn of up to 50 ms.
  CHECK(rig.bench.line.time <= silent + FlashSequencerLink::kFresh + FlashSequencerOutputs::kCutTime + milliseconds(50));
}

TEST(FlashSequencer, MakesAFaultOfALineThatIsGone) {
  Loop rig;
  rig.bench.line.here = false;
  rig.turn_for(milliseconds(20));
  CHECK_EQUAL(State::fault, rig.loop.state());
}

TEST(FlashSequencer, PlaysOverALineThatDamagesBytes) {
  Loop rig;
  rig.bench.line.damaged = 2e-4;  // of the LOADs one in twenty, of the beats one in two hundred
  int whole = 0;
  for (int i = 0; i < 10; ++i) {
    const std::size_t before = rig.pins(OutputLine::strobe_a, true).size();
    const ShotRecord& shot = rig.shoot();
    rig.bench.line.chip.pins.reserve(rig.bench.line.chip.pins.size() + 2000);
    const auto flashes = rig.pins(OutputLine::strobe_a, true);
    if (!rig.reason().empty()) continue;
    ++whole;
    CHECK_EQUAL(shot.flashes.size(), flashes.size() - before);
    std::int64_t unseen = 0;
    for (std::size_t k = 0; k < shot.flashes.size(); ++k) {
      DOUBLES_EQUAL(0.0, us(flashes[before + k].time - shot.flashes[k].issue_end), kRelated_us);
      unseen += (known(shot.flashes[k].observed_a) ? 0 : 1) + (known(shot.flashes[k].observed_b) ? 0 : 1);
    }
    CHECK_EQUAL(unseen, shot.kernel_overflows);  // every edge that was lost is known to be
    rig.turn_for(milliseconds(50));
  }
  CHECK_EQUAL(10, whole);
  CHECK(rig.all_inactive());
}

TEST(FlashSequencer, IsNeverLeftActiveByAVeryBadLine) {
  Loop rig;
  rig.bench.line.damaged = 5e-3;
  rig.bench.line.chip.pins.reserve(100'000);
  for (int i = 0; i < 10 && rig.loop.state() != State::fault; ++i) {
    rig.give(CommandKind::arm);
    rig.give(CommandKind::fire, rig.keeper.statuses.back().arm_token);
    if (!rig.play()) break;
    CHECK(rig.all_inactive());
    rig.turn_for(milliseconds(50));
  }
  MonoTime on_at;
  for (const PinChange& pin : rig.bench.line.chip.pins) {
    if (pin.line != OutputLine::strobe_a) continue;
    if (pin.active) on_at = pin.time;
    CHECK(pin.active || pin.time - on_at <= shipped_rig().lamps.max_on);
  }
}

TEST(FlashSequencer, MaySayWhatItLikes) {
  constexpr std::uint64_t kSeed = 1128;
  std::mt19937_64 random(kSeed);
  UT_PRINT(("seed " + std::to_string(kSeed)).c_str());
  const std::array templates{to_frame(flash_sequencer::Status{}), to_frame(flash_sequencer::InputEdge{}),
                             to_frame(flash_sequencer::Identity{})};
  for (int i = 0; i < 2; ++i) {
    Loop rig;
    rig.fire_until(milliseconds(20));
    bool safe = true;
    for (int k = 0; k < 2000 && safe; ++k) {
      flash_sequencer::Frame frame = templates[random() % templates.size()];
      frame.number = static_cast<std::uint8_t>(random());
      // Bytes of a status that mean something are small.
      for (std::size_t byte = 0; byte < frame.size; ++byte)
        frame.body[byte] = static_cast<std::uint8_t>(random() % (byte < 4 ? 8 : random() % 2 == 0 ? 256 : 1));
      rig.bench.line.pretend(frame);
      if (rig.loop.state() != State::firing && k % 100 == 0) {
        rig.give(CommandKind::clear);
        rig.give(CommandKind::arm);
        rig.give(CommandKind::fire, rig.keeper.statuses.back().arm_token);
      }
      if (k % 4 == 0) safe = rig.turn();
    }
    rig.turn_for(milliseconds(200));
    MonoTime on_at;
    for (const PinChange& pin : rig.bench.line.chip.pins) {
      if (pin.line != OutputLine::strobe_a) continue;
      if (pin.active) on_at = pin.time;
      CHECK(pin.active || pin.time - on_at <= shipped_rig().lamps.max_on);
    }
  }
}

TEST(FlashSequencer, IsPlayedWithoutAllocation) {
  Loop rig;
  rig.give(CommandKind::arm);
  rig.queue(CommandKind::fire, rig.keeper.statuses.back().arm_token);
  {
    const AllocationCounter allocations;
    rig.bench.line.counter = &allocations;
    rig.turn();
    CHECK(rig.play());
    rig.bench.line.counter = nullptr;
    CHECK_EQUAL(rig.bench.line.own_allocations, allocations.count());
  }
  CHECK_EQUAL(std::string(), rig.reason());
}

TEST(FlashSequencer, TellsEdgesByTheRigsClock) {
  Loop rig;
  std::array<Edge, 8> edges;
  const MonoTime gate = rig.bench.line.time + microseconds(4321);
  rig.bench.line.schedule(gate, InputLine::gate, true);
  rig.bench.line.schedule(gate + milliseconds(1), InputLine::gate, false);
  rig.bench.line.schedule(gate + milliseconds(2), InputLine::key, false);
  std::vector<Edge> told;
  while (rig.bench.line.time < gate + milliseconds(10)) {
    const auto count = rig.bench.inputs.wait(gate + milliseconds(10), edges);
    for (std::size_t i = 0; i < count.value(); ++i) told.push_back(edges[i]);
  }
  CHECK_EQUAL(2u, told.size());
  CHECK_EQUAL(Input::gate, told[0].input);
  CHECK_TRUE(told[0].active);
  DOUBLES_EQUAL(0.0, us(told[0].time - gate), kRelated_us);
  CHECK_EQUAL(Input::key, told[1].input);
  CHECK_FALSE(told[1].active);
  DOUBLES_EQUAL(2000.0, us(told[1].time - gate), kRelated_us);
  CHECK_FALSE(rig.bench.inputs.level(Input::key).value());
}

TEST(FlashSequencer, LeavesOutInputsThatAreNotFitted) {
  Rig config = shipped_rig();
  config.line(Line::gate).fitted = false;
  Loop rig(config);
  std::array<Edge, 8> edges;
  rig.bench.line.schedule(rig.bench.line.time + milliseconds(1), InputLine::gate, true);
  for (const MonoTime end = rig.bench.line.time + milliseconds(10); rig.bench.line.time < end;)
    CHECK_EQUAL(0u, rig.bench.inputs.wait(end, edges).value());
}

TEST(FlashSequencer, KnowsNoLevelOnceItIsSilent) {
  Loop rig;
  CHECK_TRUE(rig.bench.inputs.level(Input::key).value());
  CHECK_FALSE(rig.bench.inputs.level(Input::estop).value());
  rig.bench.line.answers = false;
  rig.turn_for(milliseconds(5));  // what was on its way
  rig.bench.line.spin_until(rig.bench.line.time + FlashSequencerLink::kFresh + milliseconds(10));
  CHECK_FALSE(rig.bench.inputs.level(Input::key).has_value());
}

TEST(FlashSequencer, MustAnswer) {
  VirtualSequencerLine line;
  line.answers = false;
  Heartbeat heartbeat(line, line);
  FlashSequencerLink link(line, heartbeat, line);
  const MonoTime before = line.time;
  STRCMP_EQUAL("no flash sequencer answers", link.connect(milliseconds(500)).error().message.c_str());
  CHECK(line.time - before < milliseconds(510));
}

TEST(FlashSequencer, SaysThatItsWatchdogHadResetIt) {
  VirtualSequencerLine line;
  Heartbeat heartbeat(line, line);
  FlashSequencerLink link(line, heartbeat, line);
  for (const bool by_watchdog : {true, false}) {
    line.boot(by_watchdog);
    CHECK_TRUE(link.connect(milliseconds(500)).has_value());
    CHECK_EQUAL(by_watchdog, link.reset_by_watchdog());
  }
}

TEST(FlashSequencer, IsMadeInactiveWhateverItPlays) {
  Loop rig;
  rig.fire_until(milliseconds(100));
  CHECK_FALSE(rig.all_inactive());
  // As another program does when the loop's is gone.
  FlashSequencerLink other(rig.bench.line, rig.bench.heartbeat, rig.bench.line);
  CHECK_TRUE(other.make_inactive(milliseconds(100)).has_value());
  CHECK(rig.all_inactive());
}
