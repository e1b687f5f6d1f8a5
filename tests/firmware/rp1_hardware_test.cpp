// Trains and cuts of a Raspberry Pi 5's PIO, and what becomes of them where threads stall or the block fails.
#include <cmath>
#include <cstdlib>
#include <vector>

#include "tests/firmware/rp1_hardware_bench.hpp"

using namespace strobe;
using namespace strobe::testing::rp1_hardware;

TEST_GROUP(Rp1Hardware){};

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
  const MonoTime asked = bench.begin(kLongShutter, kFlashes, milliseconds(60));
  const fs::Status status = bench.play();
  // 30 ns of each reading of the clock, a tick, a cycle; thrice 60 ppm of 40 ms from the machines' start to the instant, as the drift
  // is not known yet.
  CHECK_TRUE(bench.hardware.clocks().start_within < nanoseconds(30 + 7200));
  DOUBLES_EQUAL(0.0, static_cast<double>(status.started * kTick_ns - to_ns(asked)), 73.0);

  bench.turn_for(milliseconds(5000));
  bench.begin(kLongShutter, kFlashes, milliseconds(60));
  DOUBLES_EQUAL(0.0, begin_error_ns(bench, fs::Track::movers, kLongShutter, bench.play().started), 43.0);
  CHECK_TRUE(bench.hardware.clocks().start_within < nanoseconds(73));
}

// ---- what cuts ----

TEST(Rp1Hardware, EstopAndKeyCutWithinAMicrosecondWhateverTheProgramDoes) {
  std::mt19937 random(11);
  for (int i = 0; i < 60; ++i) {
    Bench bench(30e-6, random());
    bench.get_ready();
    const MonoTime begin = bench.begin(kLongShutter, kFlashes, milliseconds(30));
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
    CHECK_TRUE(status.played[1] > 0 && status.played[1] < kFlashes.size());
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
  const MonoTime begin = bench.begin(kLongShutter, kFlashes, milliseconds(30));
  for (int i = 0; i < 100; ++i) {
    const MonoTime at = begin + i * microseconds(500);
    bench.machine.change(at, Input::key, false);
    bench.machine.change(at + nanoseconds(300), Input::key, true);
  }
  const fs::Status status = bench.play();
  LONGS_EQUAL(CutCause::none, status.cut);
  check_edges(bench, fs::Track::lamps, kFlashes);
}

TEST(Rp1Hardware, OutputsAreLow20MsAfterTheLastBeat) {
  Bench bench;
  bench.get_ready();
  const MonoTime begin = bench.begin(kLongShutter, kFlashes, milliseconds(30));
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
    const MonoTime begin = bench.begin(kLongShutter, kFlashes, milliseconds(30));
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
  const MonoTime begin = bench.begin(kLongShutter, kFlashes, milliseconds(30));
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
  const MonoTime begin = bench.begin(kLongShutter, kFlashes, milliseconds(30));
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
    const MonoTime asked = bench.begin(kLongShutter, kFlashes, milliseconds(60));
    if (i % 3 == 0) {
      bench.block().stall = milliseconds(15);
    } else {
      bench.turn_until(asked - milliseconds(45) + bench.machine.draw({}, milliseconds(100)));
      bench.machine.stall = milliseconds(15);
    }
    const fs::Status status = bench.play();
    LONGS_EQUAL(CutCause::none, status.cut);
    check_edges(bench, fs::Track::movers, kLongShutter);
    check_edges(bench, fs::Track::lamps, kFlashes);
    // Tried again until the call took 30 us at most, half of it either way.
    CHECK_TRUE(bench.hardware.clocks().start_within <= microseconds(16));
    DOUBLES_EQUAL(static_cast<double>(to_ns(asked)), static_cast<double>(status.started * kTick_ns), 20e3);
    const auto within = static_cast<double>(bench.hardware.clocks().start_within.count()) + 13.0;
    DOUBLES_EQUAL(0.0, begin_error_ns(bench, fs::Track::movers, kLongShutter, status.started), within + 1e6 * 60e-6);
  }
}

TEST(Rp1Hardware, ATrainThatCouldNotBeginInTimeIsCutBeforeItsFirstEdge) {
  std::mt19937 random(14);
  for (int i = 0; i < 60; ++i) {
    Bench bench(0.0, random());
    bench.get_ready();
    bench.begin(pulses(0, 1, milliseconds(8), milliseconds(1), {}), kFlashes, milliseconds(2));
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
  const MonoTime begin = bench.begin(kLongShutter, kFlashes, milliseconds(30));
  bench.turn_until(begin + milliseconds(10));
  bench.block().dma_word = milliseconds(1000);
  LONGS_EQUAL(CutCause::underrun, bench.play().cut);
  CHECK_TRUE(all_low(bench));
  // Eight words are queued and two are in the machine: 2.5 ms of kFlashes. Then two looks .4 ms apart, each a turn of .8 ms
  // and calls later at most.
  CHECK_TRUE(last_change(bench) < begin + milliseconds(10) + microseconds(2500 + 2000));
}

TEST(Rp1Hardware, NothingOfATrainThatWasCutIsPlayedInTheNext) {
  std::mt19937 random(21);
  for (int i = 0; i < 20; ++i) {
    Bench bench(0.0, random());
    bench.get_ready();
    const MonoTime begin = bench.begin(kLongShutter, kFlashes, milliseconds(30));
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
  bench.begin(pulses(0, 1, milliseconds(1), milliseconds(25'000), {}), kFlashes, milliseconds(30));
  LONGS_EQUAL(CutCause::underrun, bench.play().cut);
  CHECK_TRUE(bench.block().pins.empty());
}

TEST(Rp1Hardware, OutputsOfABlockThatIsGoneAreLowWithin20Ms) {
  Bench bench;
  bench.get_ready();
  const MonoTime begin = bench.begin(kLongShutter, kFlashes, milliseconds(30));
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
  bench.begin(kLongShutter, kFlashes, milliseconds(30));
  LONGS_EQUAL(CutCause::none, bench.play().cut);
  check_edges(bench, fs::Track::lamps, kFlashes);
}

TEST(Rp1Hardware, WhateverAFlakyBlockDoesOnlyATrainThatPlaysHasOutputsOn) {
  std::mt19937 random(18);
  int whole = 0, cut = 0;
  for (int i = 0; i < 150; ++i) {
    Bench bench(10e-6, random());
    bench.get_ready();
    bench.begin(kLongShutter, kFlashes, milliseconds(30));
    bench.flaky.share = std::pow(10.0, -1.0 - 0.5 * (i % 5));
    (void)bench.play();
    const MonoTime over = bench.machine.at();
    bench.turn_for(milliseconds(50));
    bench.flaky.share = 0.0;
    bench.turn_for(milliseconds(50));
    CHECK_TRUE(all_low(bench));
    if (!bench.block().pins.empty()) CHECK_TRUE(last_change(bench) <= over + milliseconds(20));
    if (bench.ask(fs::to_frame(Request::beat)).cut == CutCause::none) {
      check_edges(bench, fs::Track::movers, kLongShutter);
      check_edges(bench, fs::Track::lamps, kFlashes);
      ++whole;
    } else {
      bench.carry_out(fs::to_frame(Request::reset));
      ++cut;
    }
  }
  CHECK_TRUE(whole > 20 && cut > 20);
}
