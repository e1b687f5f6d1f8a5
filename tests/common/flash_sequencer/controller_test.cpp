#include "common/flash_sequencer/controller.hpp"

#include <algorithm>
#include <deque>
#include <random>
#include <vector>

#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::flash_sequencer;

namespace {

constexpr Ticks kMs = ticks_of_us(1000);
constexpr std::uint8_t kKeyOn = bit(InputLine::key);

/// Plays a train by the time that the test sets.
struct FakeHardware final : Hardware {
  Ticks time = 1'000'000;
  std::uint8_t levels = kKeyOn;
  bool may_be_driven = false, prepared = false, started = false, gated = false, listens = false, underrun = false;
  CutCause by_itself = CutCause::none;
  Ticks starts_at = 0, gate_at = kNoTicks;
  std::array<std::vector<Edge>, kTrackCount> tracks;
  Progress told;
  std::uint32_t drawn = 0;
  int starts = 0;
  std::deque<InputEdge> edges;

  Ticks now() override { return time; }
  void prepare(std::span<Edge> movers, std::span<Edge> lamps) override {
    tracks = {std::vector(movers.begin(), movers.end()), std::vector(lamps.begin(), lamps.end())};
    told = {};
    prepared = true;
    started = false;
    gate_at = kNoTicks;
  }
  void start(Ticks at, bool is_gated) override {
    CHECK(prepared && may_be_driven && !started);
    started = true;
    starts_at = at;
    gated = is_gated;
    ++starts;
  }
  void listen_to_gate(bool is_listened_to) override { listens = is_listened_to; }
  Progress progress() override { return told; }
  void cut() override {
    look();
    may_be_driven = prepared = started = listens = false;
  }
  bool release() override {
    by_itself = CutCause::none;
    return may_be_driven = levels == kKeyOn;
  }
  CutCause cut_by_itself() override { return by_itself; }
  std::uint8_t inputs() override { return levels; }
  std::uint8_t outputs() override { return look(); }
  bool pop_input(InputEdge& edge) override {
    if (edges.empty()) return false;
    edge = edges.front();
    edges.pop_front();
    return true;
  }
  std::uint16_t lost_inputs() override { return 7; }
  std::uint32_t random() override { return drawn++; }

  void set_levels(std::uint8_t now_have) {
    levels = now_have;
    if (levels == kKeyOn || !may_be_driven) return;
    look();
    by_itself = (levels & bit(InputLine::estop)) != 0 ? CutCause::estop : CutCause::key;
    may_be_driven = started = false;
  }
  void gate_edge() {
    if (started && gated && listens && gate_at == kNoTicks) gate_at = time;
  }
  /// The outputs at `time`.
  std::uint8_t look() {
    if (!started || underrun) return 0;
    if (time >= starts_at) told.started = starts_at;
    told.burst_started = gated ? gate_at : told.started;
    std::uint32_t active = 0;
    for (std::size_t track = 0; track < kTrackCount; ++track) {
      Ticks at = track == 0 ? told.started : told.burst_started;
      if (at == kNoTicks) continue;
      std::uint16_t played = 0;
      std::uint32_t have = 0;
      for (const Edge& edge : tracks[track]) {
        if ((at += edge.delay) > time) break;
        have = edge.levels;
        ++played;
      }
      told.played[track] = played;
      active |= have;
    }
    return static_cast<std::uint8_t>(active);
  }
};

/// Of so many flashes of both lamps, 3 ms apart, while the shutter is open; the trigger in between.
struct Train {
  std::vector<Edge> movers{{125, 1}, {25'000, 3}, {125'000, 1}, {2'000'000, 0}};
  std::vector<Edge> lamps;
  explicit Train(int flashes = 5) {
    for (int i = 0; i < flashes; ++i) {
      lamps.push_back({375'000 - 6250, 0b1100});
      lamps.push_back({6250, 0});
    }
  }
};

}  // namespace

TEST_GROUP(SequencerController) {
  FakeHardware hardware;
  Controller controller{hardware, 77, true};
  std::uint8_t number = 0;

  Status ask_again(const Frame& request) {
    Frame reply;
    CHECK(controller.answer(request, hardware.time, reply));
    CHECK_EQUAL(request.number, reply.number);
    const auto status = read_status(reply);
    CHECK(status.has_value());
    return *status;
  }
  Status ask(Frame request) {
    request.number = ++number;
    return ask_again(request);
  }
  Refusal refusal_of(const Frame& request) { return ask(request).refusal; }
  void granted(const Frame& request) { CHECK_EQUAL(Refusal::none, refusal_of(request)); }

  void get_ready(std::uint32_t max_on_us = 100'000) {
    granted(to_frame(Limits{{max_on_us, max_on_us, max_on_us, max_on_us, 0, 0}}));
    granted(to_frame(Request::reset));
    beat();
  }
  void beat() { granted(to_frame(Request::beat)); }
  void load(Track track, const std::vector<Edge>& edges) {
    Load load;
    load.track = track;
    do {
      load.count = static_cast<std::uint16_t>(std::min(edges.size() - load.first, Load::kMaxEdges));
      std::copy_n(edges.begin() + load.first, load.count, load.edges.begin());
      granted(to_frame(load));
      load.first = static_cast<std::uint16_t>(load.first + load.count);
    } while (load.first < edges.size());
  }
  static Arm arm_of(const Train& train, bool gated) {
    return {{static_cast<std::uint16_t>(train.movers.size()), static_cast<std::uint16_t>(train.lamps.size())},
            train_crc(train.movers, train.lamps),
            static_cast<std::uint8_t>(gated)};
  }
  Status arm(const Train& train, bool gated = false) {
    load(Track::movers, train.movers);
    load(Track::lamps, train.lamps);
    return ask(to_frame(arm_of(train, gated)));
  }
  void play(const Train& train, bool gated = false) {
    const Status armed = arm(train, gated);
    CHECK_EQUAL(Refusal::none, armed.refusal);
    CHECK_EQUAL(Phase::armed, armed.phase);
    granted(to_frame(Start{armed.challenge, hardware.time + kMs, 2 * kMs, 10 * kMs}));
    CHECK_EQUAL(Phase::playing, controller.phase());
  }
  void pass_ms(int ms, bool beats = true) {
    for (int i = 0; i < ms; ++i) {
      hardware.time += kMs;
      hardware.look();
      if (beats) beat();
      controller.turn();
    }
  }
  void check_cut(CutCause cause) {
    CHECK_EQUAL(Phase::cut, controller.phase());
    const Status status = ask(to_frame(Request::beat));
    CHECK_EQUAL(cause, status.cut);
    CHECK_EQUAL(0, status.outputs);
    CHECK_FALSE(hardware.may_be_driven);
    CHECK_EQUAL(Refusal::wrong_phase, refusal_of(to_frame(Load{})));
  }
};

TEST(SequencerController, IsCutUntilItIsReset) {
  check_cut(CutCause::none);
  Frame reply, hello = to_frame(Request::hello);
  CHECK(controller.answer(hello, 0, reply));
  const auto identity = read_identity(reply);
  CHECK(identity.has_value());
  CHECK_EQUAL(77U, identity->boot);
  CHECK_EQUAL(1, identity->reset_by_watchdog);
  granted(to_frame(Request::reset));
  CHECK_EQUAL(Phase::idle, controller.phase());
  granted(to_frame(Request::reset));
}

TEST(SequencerController, PlaysATrainToItsEnd) {
  get_ready();
  const Train train;
  play(train);
  pass_ms(30);
  const Status status = ask(to_frame(Request::beat));
  CHECK_EQUAL(Phase::idle, status.phase);
  CHECK_EQUAL(CutCause::none, status.cut);
  CHECK_EQUAL(4, status.played[0]);
  CHECK_EQUAL(10, status.played[1]);
  CHECK_EQUAL(hardware.starts_at, status.started);
  CHECK_EQUAL(7, status.lost_inputs);
  CHECK_EQUAL(Refusal::train_differs, refusal_of(to_frame(arm_of(train, false))));  // it is loaded anew each time
  play(train);
  pass_ms(30);
  CHECK_EQUAL(2, hardware.starts);
}

TEST(SequencerController, ATrainIsArmedOnlyIfItIsWhatWasLoadedAndHarmless) {
  get_ready();
  const auto why = [&](const Train& train) {
    const Status status = arm(train);
    CHECK_EQUAL(Phase::idle, status.phase);
    CHECK_EQUAL(0U, status.challenge);
    return status.refusal;
  };
  Train train;
  train.lamps.back().levels = 0b0100;
  CHECK_EQUAL(Refusal::ends_active, why(train));
  train = Train();
  train.lamps[3].levels = 1;
  CHECK_EQUAL(Refusal::foreign_line, why(train));
  train = Train();
  train.lamps[3].delay = kMinDelay - 1;
  CHECK_EQUAL(Refusal::delay_too_short, why(train));
  train = Train();
  train.lamps[3].levels = 0b10000;  // an output without a limit is never on
  train.lamps[4].levels = 0;
  CHECK_EQUAL(Refusal::on_too_long, why(train));
  train = Train();
  load(Track::movers, train.movers);
  load(Track::lamps, train.lamps);
  Arm other = arm_of(train, false);
  other.crc ^= 1;
  CHECK_EQUAL(Refusal::train_differs, refusal_of(to_frame(other)));
  other = arm_of(train, false);
  --other.edges[1];
  CHECK_EQUAL(Refusal::train_differs, refusal_of(to_frame(other)));
  CHECK_FALSE(hardware.prepared);
}

TEST(SequencerController, AnOutputIsOnForItsLimitAndNoTickLonger) {
  get_ready(1000);
  Train train(1);
  train.movers.clear();
  train.lamps = {{1000, 0b0100}, {60'000, 0b1100}, {65'000, 0b1000}, {60'000, 0}};  // 1 ms each: 125,000 ticks
  CHECK_EQUAL(Refusal::none, arm(train).refusal);
  granted(to_frame(Request::abort));
  granted(to_frame(Request::reset));
  ++train.lamps[2].delay;
  CHECK_EQUAL(Refusal::on_too_long, arm(train).refusal);
}

TEST(SequencerController, EdgesFollowOneAnotherAndThereAreNotTooMany) {
  get_ready();
  Load load;
  load.count = 1;
  load.first = 1;
  CHECK_EQUAL(Refusal::bad_index, refusal_of(to_frame(load)));
  for (load.first = 0; load.first < kMaxEdges; ++load.first) granted(to_frame(load));
  CHECK_EQUAL(Refusal::bad_index, refusal_of(to_frame(load)));
  load.first = 0;
  granted(to_frame(load));
}

TEST(SequencerController, ArmsAndStartsWithKeyBeatsAndEstopReleasedOnly) {
  get_ready();
  const Train train;
  pass_ms(16, false);
  CHECK_EQUAL(Refusal::no_heartbeat, arm(train).refusal);
  beat();
  hardware.levels = 0;
  CHECK_EQUAL(Refusal::key_off, arm(train).refusal);
  hardware.levels = kKeyOn | bit(InputLine::estop);
  CHECK_EQUAL(Refusal::estop_pressed, arm(train).refusal);
  hardware.levels = kKeyOn;
  const Status armed = arm(train);
  CHECK_EQUAL(Refusal::none, armed.refusal);
  const Ticks at = hardware.time + kMs;
  CHECK_EQUAL(Refusal::wrong_challenge, refusal_of(to_frame(Start{armed.challenge + 1, at, 0, 0})));
  CHECK_EQUAL(Refusal::too_late, refusal_of(to_frame(Start{armed.challenge, hardware.time + kStartLead - 1, 0, 0})));
  CHECK_EQUAL(Refusal::malformed, refusal_of(to_frame(Start{armed.challenge, hardware.time + kMaxAhead + 1, 0, 0})));
  CHECK_EQUAL(Refusal::malformed, refusal_of(to_frame(Start{armed.challenge, at, 5, 4})));
  hardware.levels = 0;
  CHECK_EQUAL(Refusal::key_off, refusal_of(to_frame(Start{armed.challenge, at, 0, 0})));
  hardware.levels = kKeyOn;
  CHECK_EQUAL(0, hardware.starts);
  granted(to_frame(Start{armed.challenge, hardware.time + kStartLead, 0, 0}));
  CHECK_EQUAL(Refusal::wrong_phase, refusal_of(to_frame(Start{armed.challenge, at, 0, 0})));
  CHECK_EQUAL(1, hardware.starts);
}

TEST(SequencerController, AChallengeIsNeverZero) {
  get_ready();
  hardware.drawn = 0;
  CHECK(arm(Train()).challenge != 0);
}

TEST(SequencerController, ArmedLastsForASecond) {
  get_ready();
  const Status armed = arm(Train());
  pass_ms(1000);
  CHECK_EQUAL(Phase::armed, controller.phase());
  pass_ms(1);
  CHECK_EQUAL(Phase::idle, controller.phase());
  CHECK_EQUAL(Refusal::wrong_phase, refusal_of(to_frame(Start{armed.challenge, hardware.time + kMs, 0, 0})));
  play(Train());
}

TEST(SequencerController, SilenceOfFifteenMillisecondsCutsATrain) {
  get_ready();
  play(Train(50));
  pass_ms(20);
  pass_ms(15, false);
  CHECK_EQUAL(Phase::playing, controller.phase());
  hardware.time += 1;
  controller.turn();
  check_cut(CutCause::heartbeat);
  pass_ms(100);
  CHECK_EQUAL(Phase::cut, controller.phase());
}

TEST(SequencerController, ABeatThatComesTooLateDoesNotSaveTheTrain) {
  get_ready();
  play(Train(50));
  hardware.time += kHeartbeatTimeout + 1;
  beat();
  check_cut(CutCause::heartbeat);
}

TEST(SequencerController, IsCutByEachCause) {
  const auto check = [&](CutCause cause, auto&& happens) {
    get_ready();
    play(Train(50));
    pass_ms(10);
    happens();
    pass_ms(1);
    check_cut(cause);
    hardware.levels = kKeyOn;
    hardware.underrun = false;
  };
  check(CutCause::abort, [&] { granted(to_frame(Request::abort)); });
  check(CutCause::key, [&] { hardware.set_levels(0); });
  check(CutCause::estop, [&] { hardware.set_levels(kKeyOn | bit(InputLine::estop)); });
  check(CutCause::underrun, [&] { hardware.told.underrun = hardware.underrun = true; });
  check(CutCause::overrun, [&] {
    hardware.underrun = true;  // stands still
    pass_ms(142);              // since 10; 50 flashes take 150 from a start after 1
    CHECK_EQUAL(Phase::playing, controller.phase());
    pass_ms(2);
  });
}

TEST(SequencerController, ACutStaysUntilKeyAndEstopAllowAReset) {
  get_ready();
  hardware.set_levels(0);
  controller.turn();
  check_cut(CutCause::key);
  CHECK_EQUAL(Refusal::key_off, refusal_of(to_frame(Request::reset)));
  hardware.levels = kKeyOn | bit(InputLine::estop);
  CHECK_EQUAL(Refusal::estop_pressed, refusal_of(to_frame(Request::reset)));
  granted(to_frame(Request::abort));
  check_cut(CutCause::key);  // the first of several
  hardware.levels = kKeyOn;
  check_cut(CutCause::key);
  get_ready();
  play(Train());
  CHECK_EQUAL(Refusal::wrong_phase, refusal_of(to_frame(Request::reset)));
}

TEST(SequencerController, AGatedBurstBeginsWithTheGateInItsWindow) {
  get_ready();
  play(Train(), true);
  hardware.time += 2 * kMs;  // the window opens 2 ms after a start in 1 ms
  controller.turn();
  hardware.gate_edge();
  pass_ms(1);
  CHECK_TRUE(hardware.listens);
  CHECK_EQUAL(kNoTicks, hardware.gate_at);
  hardware.time += kMs;
  hardware.gate_edge();
  const Ticks gate_at = hardware.time;
  pass_ms(10);
  CHECK_FALSE(hardware.listens);
  pass_ms(20);
  const Status status = ask(to_frame(Request::beat));
  CHECK_EQUAL(Phase::idle, status.phase);
  CHECK_EQUAL(gate_at, status.burst_started);
  CHECK_EQUAL(10, status.played[1]);
}

TEST(SequencerController, AGatedShotWithoutTheGateEndsWithItsWindow) {
  get_ready();
  Train train;
  train.movers = {{125, 1}, {125'000, 0}};
  play(train, true);
  pass_ms(10);
  CHECK_EQUAL(Phase::playing, controller.phase());
  pass_ms(1);
  hardware.gate_edge();
  pass_ms(1);
  const Status status = ask(to_frame(Request::beat));
  CHECK_EQUAL(Phase::idle, status.phase);
  CHECK_EQUAL(0, status.played[1]);
  CHECK_EQUAL(kNoTicks, status.burst_started);
}

TEST(SequencerController, ARepeatedRequestIsAnsweredButNotCarriedOut) {
  get_ready();
  const Train train;
  const Status armed = arm(train);
  Frame start = to_frame(Start{armed.challenge, hardware.time + kMs, 0, 0});
  start.number = 200;
  CHECK_EQUAL(Refusal::none, ask_again(start).refusal);
  const Ticks received = hardware.time;
  hardware.time += 10;
  beat();
  const Status again = ask_again(start);
  CHECK_EQUAL(Refusal::none, again.refusal);
  CHECK_EQUAL(received, again.received);
  CHECK_EQUAL(1, hardware.starts);
  start.number = 201;
  CHECK_EQUAL(Refusal::wrong_phase, ask_again(start).refusal);
}

TEST(SequencerController, AnAbortIsCarriedOutHoweverOftenItIsHeard) {
  get_ready();
  Frame abort = to_frame(Request::abort);
  ask_again(abort);
  granted(to_frame(Request::reset));
  beat();
  play(Train());
  ask_again(abort);
  check_cut(CutCause::abort);
}

TEST(SequencerController, WhatIsNoRequestGetsNoAnswerAndAWrongBodyIsMalformed) {
  Frame reply;
  for (const int kind : {0, 9, 0x81, 0x83, 255}) {
    Frame frame;
    frame.kind = static_cast<std::uint8_t>(kind);
    CHECK_FALSE(controller.answer(frame, 0, reply));
  }
  for (const Request kind : {Request::hello, Request::limits, Request::load, Request::arm, Request::start}) {
    Frame frame;
    frame.kind = static_cast<std::uint8_t>(kind);
    CHECK_EQUAL(Refusal::malformed, refusal_of(frame));
  }
}

TEST(SequencerController, NumbersTheInputsEdges) {
  hardware.edges = {{0, InputLine::gate, 1, 5}, {0, InputLine::key, 0, 6}};
  Frame report;
  CHECK(controller.next_input(report));
  CHECK_EQUAL(0, read_input(report)->number);
  CHECK(controller.next_input(report));
  CHECK_EQUAL(1, read_input(report)->number);
  CHECK_EQUAL(6, read_input(report)->time);
  CHECK_FALSE(controller.next_input(report));
  CHECK_EQUAL(2, ask(to_frame(Request::beat)).next_input);
}

// What the test itself has sent says what may play: a start needs beats, key, e-stop, a whole train and its arming's
// challenge, all since the last cut; outputs are active within a heartbeat's timeout and a turn of a beat.
TEST(SequencerController, WhateverComesNothingPlaysThatWasNotArmedAndKeptAlive) {
  constexpr unsigned kSeed = 7;
  std::mt19937 random(kSeed);
  get_ready();
  Ticks beaten = hardware.time;
  std::uint32_t challenge = 0;  // of an arming since which nothing was cut
  const Train train(20);
  long played = 0, cuts = 0;
  const auto heard = [&](const Status& status) {
    if (status.phase == Phase::cut) challenge = 0;
    if (status.answers == Request::arm && status.refusal == Refusal::none) challenge = status.challenge;
  };
  for (int step = 0; step < 40'000; ++step) {
    const int starts = hardware.starts;
    const Phase before = controller.phase();
    switch (random() % 16) {
      case 0: heard(ask(to_frame(Request::reset))); break;
      case 1: if (random() % 8 == 0) heard(ask(to_frame(Request::abort))); break;
      case 2: if (random() % 8 == 0) hardware.set_levels(random() % 4 == 0 ? 0 : kKeyOn); break;
      case 3: if (random() % 8 == 0) hardware.set_levels(random() % 3 == 0 ? kKeyOn | bit(InputLine::estop) : kKeyOn); break;
      case 4: if (random() % 6 == 0) hardware.time += static_cast<Ticks>(random() % 20) * kMs; break;
      case 5:
      case 6:
        if (before == Phase::idle) {
          load(Track::movers, train.movers);
          load(Track::lamps, train.lamps);
        }
        break;
      case 7:
      case 8: heard(ask(to_frame(arm_of(train, random() % 2 == 0)))); break;
      case 9:
      case 10: {
        const std::uint32_t claimed = random() % 4 == 0 ? static_cast<std::uint32_t>(random() % 100) : challenge;
        const std::uint32_t valid = challenge;
        heard(ask(to_frame(Start{claimed, hardware.time + static_cast<Ticks>(random() % 3) * kMs, 0, 20 * kMs})));
        if (hardware.starts != starts) {
          CHECK(valid != 0 && claimed == valid);
          CHECK_EQUAL(kKeyOn, hardware.levels);
          CHECK(hardware.time - beaten <= kHeartbeatTimeout);
          CHECK(hardware.tracks[0].size() == train.movers.size() && hardware.tracks[1].size() == train.lamps.size());
          challenge = 0;
          ++played;
        }
        break;
      }
      case 11: {
        Frame noise;
        noise.kind = static_cast<std::uint8_t>(random() % 6);  // no abort, no reset
        noise.size = static_cast<std::uint8_t>(random() % 60);
        for (auto& byte : noise.body) byte = static_cast<std::uint8_t>(random() % 3);
        Frame reply;
        controller.answer(noise, hardware.time, reply);
        break;
      }
      case 12: hardware.gate_edge(); break;
      default:
        heard(ask(to_frame(Request::beat)));
        beaten = hardware.time;
    }
    const bool started = hardware.starts != starts;
    CHECK(!started || before == Phase::armed);
    hardware.time += static_cast<Ticks>(random() % 1000) * kMs / 1000;
    controller.turn();
    if (controller.phase() == Phase::cut) {
      challenge = 0;
      cuts += before != Phase::cut;
    }
    const std::uint8_t active = hardware.look();
    CHECK(active == 0 || (controller.phase() == Phase::playing && hardware.levels == kKeyOn));
    CHECK(active == 0 || hardware.time - beaten <= kHeartbeatTimeout);
    CHECK(controller.phase() != Phase::cut || !hardware.may_be_driven);
  }
  CHECK(played > 100 && cuts > 100);
}
