// Trains of unequal intervals, with flashes left out and flashes of one lamp, from the plan to the record.
#include <rapidcheck.h>

#include <array>
#include <string>
#include <vector>

#include "tests/support/sequencer_fixture.hpp"

#include "tests/support/error_of.hpp"
#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::firmware;
using strobe::testing::kFirstFlashAt;
using strobe::testing::SequencerFixture;
using strobe::testing::shipped_rig;

namespace {

/// 0, 3, 6.4 ms ... with flash 2 of lamp A alone, flash 5 of lamp B alone, and a gap after flash 7.
CodedTrain some_code() {
  CodedTrain code;
  Duration at{};
  for (int k = 0; k < 12; ++k) {
    code.push_back({at, k == 2 ? Lamps::a : k == 5 ? Lamps::b : Lamps::both});
    at = at + microseconds(k % 3 == 1 ? 3400 : 3000) + (k == 7 ? milliseconds(3) : Duration{});
  }
  return code;
}

std::string refusal(const ShotPlan& request, const Rig& rig) {
  return testing::error_of(check_plan(request, rig));
}

}  // namespace

TEST_GROUP(CodedPlan) {
  Rig rig = shipped_rig();
  ShotPlan request = rig.plan;

  void add(std::int64_t us, Lamps lamps = Lamps::both) { request.code.push_back({microseconds(us), lamps}); }
};

TEST(CodedPlan, HasItsFlashesAtTheirOffsetsFromTheOpening) {
  request.code = some_code();
  CHECK_EQUAL(std::string(), refusal(request, rig));
  PulseSchedule plan;
  plan.reserve(rig.lamps.max_flashes);
  build_schedule(request, rig, plan);
  CHECK_EQUAL(12, plan.flash_count);
  CHECK_EQUAL(milliseconds(3), plan.shortest_interval);
  std::size_t k = 0;
  for (const PlannedPulse& pulse : plan.pulses) {
    if (pulse.output != Output::strobes) continue;
    CHECK_EQUAL(request.code[k].offset, pulse.at - plan.exposure_begin);
    CHECK_EQUAL(request.code[k].lamps, pulse.lamps);
    CHECK_EQUAL(static_cast<std::int32_t>(k), pulse.flash_index);
    ++k;
  }
  CHECK_EQUAL(12u, k);
}

TEST(CodedPlan, GivesEachLampItsOwnRechargeTime) {
  add(0, Lamps::a);
  add(750, Lamps::b);
  add(1500, Lamps::a);
  add(2250, Lamps::b);
  CHECK_EQUAL(std::string(), refusal(request, rig));
  add(3700, Lamps::b);
  CHECK_EQUAL(
      "flash 4 of the coded train comes 1450 us after lamp B's one before, shorter than the lamps' 1500 us",
      refusal(request, rig));
}

TEST(CodedPlan, CountsAFlashOfBothForEither) {
  add(0, Lamps::both);
  add(1000, Lamps::a);
  STRCMP_CONTAINS("lamp A's one before", refusal(request, rig).c_str());
}

TEST(CodedPlan, RefusesFlashesOfDifferentLampsBetweenWhichTheLoopCouldNotLookAtTheInputs) {
  // A pulse of at most 200 us and a spin of 200 us must fit between.
  add(0, Lamps::a);
  add(400, Lamps::b);
  CHECK_EQUAL(
      "flash 1 of the coded train comes 400 us after the one before, where more than 400 us are needed",
      refusal(request, rig));
  request.code = {};
  add(0, Lamps::a);
  add(401, Lamps::b);
  CHECK_EQUAL(std::string(), refusal(request, rig));
}

TEST(CodedPlan, RefusesWhatGoesBackwardsOrNamesNoLamp) {
  add(3000);
  add(3000);
  STRCMP_CONTAINS("comes 0 us after", refusal(request, rig).c_str());
  request.code = {};
  add(3000);
  add(0);
  STRCMP_CONTAINS("comes -3000 us after", refusal(request, rig).c_str());
  request.code = {};
  add(0, static_cast<Lamps>(0));
  STRCMP_CONTAINS("names no lamp", refusal(request, rig).c_str());
  request.code = {};
  add(0, static_cast<Lamps>(4));
  STRCMP_CONTAINS("names no lamp", refusal(request, rig).c_str());
  for (const std::int64_t ns : {INT64_MIN, std::int64_t{-1}, INT64_MAX}) {
    request.code = {};
    request.code.push_back({nanoseconds(ns), Lamps::both});
    STRCMP_CONTAINS("flash 0 of the coded train is not from 0 to 1 h after the first", refusal(request, rig).c_str());
  }
}

TEST(CodedPlan, RefusesATrainLongerThanTheExposure) {
  add(0);
  add(499'999);
  CHECK_EQUAL(std::string(), refusal(request, rig));
  request.code = {};
  add(500'000);
  STRCMP_CONTAINS("takes 500 ms, longer than the exposure of 500 ms", refusal(request, rig).c_str());
}

TEST(CodedPlan, RefusesMoreFlashesThanAShotMayHave) {
  rig.lamps.max_flashes = 3;
  for (int k = 0; k < 4; ++k) add(3000 * k);
  STRCMP_CONTAINS("4 flashes are more than the 3", refusal(request, rig).c_str());
}

TEST(CodedPlan, OfAGatedTrainHasTheFlashesThatItCounts) {
  request.train = Train::gated;
  request.flash_count = 3;
  for (int k = 0; k < 4; ++k) add(3000 * k);
  STRCMP_CONTAINS("is not that of the coded train", refusal(request, rig).c_str());
  request.flash_count = 4;
  CHECK_EQUAL(std::string(), refusal(request, rig));
  add(499'000);
  request.flash_count = 5;
  request.gate_delay = milliseconds(1);
  STRCMP_CONTAINS("longer than the exposure", refusal(request, rig).c_str());
}

TEST_GROUP(CodedTrain){static Rig coded(const CodedTrain& code){Rig rig = shipped_rig();
rig.plan.code = code;
return rig;
}
}
;

TEST(CodedTrain, IsPlayedAsPlannedAndTellsItsLamps) {
  SequencerFixture bench(coded(some_code()));
  const MonoTime start = bench.shoot();
  const ShotRecord& shot = bench.shot();
  CHECK(shot.abort_reason.empty());
  const CodedTrain code = some_code();
  CHECK_EQUAL(code.size(), shot.flashes.size());
  for (std::size_t k = 0; k < code.size(); ++k) {
    const FlashRecord& flash = shot.flashes[k];
    CHECK_EQUAL(code[k].lamps, flash.lamps);
    CHECK_EQUAL(start + kFirstFlashAt + code[k].offset, flash.commanded);
    CHECK(flash.issue_start >= flash.commanded && flash.issue_start - flash.commanded < microseconds(1));
    CHECK_EQUAL(has_a(flash.lamps), known(flash.observed_a));
    CHECK_EQUAL(has_b(flash.lamps), known(flash.observed_b));
    CHECK_EQUAL(0, flash.extra_edges);
    const Line line = k == 2 ? Line::strobe_a : k == 5 ? Line::strobe_b : Line::none;
    CHECK_EQUAL(line, bench.rig.find(EventKind::flash, k)->line);
  }
}

TEST(CodedTrain, DrivesTheLinesOfTheNamedLampsOnly) {
  SequencerFixture bench(coded(some_code()));
  bench.shoot();
  std::vector<Lamps> driven;
  for (const auto& set : bench.rig.sets)
    if (set.output == Output::strobes && set.active) driven.push_back(set.lamps);
  CHECK_EQUAL(12u, driven.size());
  for (std::size_t k = 0; k < driven.size(); ++k) CHECK_EQUAL(some_code()[k].lamps, driven[k]);
}

TEST(CodedTrain, CountsLightInTheGapOfAnOmittedFlash) {
  SequencerFixture bench(coded(some_code()));
  const MonoTime start = bench.fire();
  const MonoTime omitted = start + kFirstFlashAt + some_code()[7].offset + milliseconds(3);
  bench.rig.schedule({Input::sensor_a, omitted, true});
  bench.play();
  CHECK_EQUAL(1, bench.shot().flashes[7].extra_edges);
  CHECK_EQUAL(0, bench.shot().flashes[8].extra_edges);
}

TEST(CodedTrain, IsStoppedByAFlashThatIsLateBeyondTheLimitAndTheShotIsSpent) {
  SequencerFixture bench(coded(some_code()));
  const MonoTime start = bench.fire();
  const MonoTime sixth = start + kFirstFlashAt + some_code()[6].offset;
  bench.rig.freeze(sixth - microseconds(300),
                   microseconds(300) + bench.config.tolerance.abort_late + microseconds(10));
  bench.play();
  STRCMP_CONTAINS("flash 6 would have been", bench.abort_reason().c_str());
  CHECK(bench.rig.all_inactive());
  CHECK_EQUAL(6u, bench.rig.instants(Output::strobes).size());
  CHECK_EQUAL(State::spent, bench.sequencer.state());
  const auto refused = bench.rig.count(EventKind::refused);
  bench.give(bench.fire_command(1));
  CHECK_EQUAL(refused + 1, bench.rig.count(EventKind::refused));
  CHECK_EQUAL(1u, bench.rig.count(EventKind::shot_started));
}

TEST(CodedTrain, IsStoppedRatherThanCaughtUpWith) {
  // Lamps in turn, so that neither lamp's recharge time forbids the next flash: its neighbour's lateness
  // does.
  CodedTrain code;
  for (int k = 0; k < 20; ++k) code.push_back({microseconds(800) * k, k % 2 == 0 ? Lamps::a : Lamps::b});
  SequencerFixture bench(coded(code));
  const MonoTime start = bench.fire(), tenth = start + kFirstFlashAt + code[10].offset;
  bench.rig.freeze(tenth - microseconds(100),
                   microseconds(800));  // flash 10 is 700 us late, 11 is due in 100 us
  bench.play();
  STRCMP_CONTAINS("flash 11 would have come", bench.abort_reason().c_str());
  CHECK(bench.rig.all_inactive());
  CHECK_EQUAL(11u, bench.rig.instants(Output::strobes).size());
}

TEST(CodedTrain, OfTheGateStartsWhenTheGateSaysSo) {
  Rig rig = coded(some_code());
  rig.plan.train = Train::gated;
  rig.plan.flash_count = 12;
  SequencerFixture bench(rig);
  const MonoTime start = bench.fire(), ball = start + kFirstFlashAt + milliseconds(200);
  bench.rig.schedule({Input::gate, ball, true});
  bench.play();
  CHECK(bench.shot().abort_reason.empty());
  CHECK_EQUAL(ball + some_code()[4].offset, bench.shot().flashes[4].commanded);
  CHECK_EQUAL(Lamps::b, bench.shot().flashes[5].lamps);
  CHECK_FALSE(known(bench.shot().flashes[5].observed_a));
}

namespace {

struct Step {
  int gap_us, lamps;
};

rc::Gen<std::vector<Step>> steps() {
  return rc::gen::container<std::vector<Step>>(rc::gen::build<Step>(
      rc::gen::set(&Step::gap_us, rc::gen::weightedElement<int>(
                                      {{1, 395}, {2, 401}, {2, 700}, {4, 760}, {4, 1500}, {6, 3000}})),
      rc::gen::set(&Step::lamps, rc::gen::inRange(1, 4))));
}

/// Flashes of a lamp (1 or 2; 3: of either) that come too soon after one before, by comparing every two.
bool any_too_soon(const CodedTrain& code, int lamps, Duration least) {
  for (std::size_t i = 0; i < code.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      const int shared = static_cast<int>(code[i].lamps) & static_cast<int>(code[k].lamps) & lamps;
      if ((shared != 0 || lamps == 3) && code[i].offset - code[k].offset < least) return true;
    }
  }
  return false;
}

}  // namespace

TEST(CodedTrain, IsGrantedExactlyWhereTheLampsAndTheLoopCanFollow) {
  const bool holds = rc::check("granted where two flashes are far enough apart", [] {
    const Rig rig = shipped_rig();
    ShotPlan request = rig.plan;
    Duration at{};
    for (const Step& step : *steps()) {
      request.code.push_back({at, static_cast<Lamps>(step.lamps)});
      at = at + microseconds(step.gap_us);
    }
    const bool too_soon = any_too_soon(request.code, 1, rig.lamps.min_period) ||
                          any_too_soon(request.code, 2, rig.lamps.min_period) ||
                          any_too_soon(request.code, 3, min_flash_interval(rig) + nanoseconds(1));
    RC_ASSERT(refusal(request, rig).empty() != too_soon);
    RC_CLASSIFY(!too_soon, "granted");
  });
  CHECK_TRUE(holds);
}

TEST(CodedTrain, KeepsEveryLampsLimitsThroughFreezes) {
  const bool holds = rc::check("each lamp recharges, no pulse is too long, no burst catches up", [] {
    Rig config = shipped_rig();
    config.plan.exposure = milliseconds(100);
    config.plan.impact_at = milliseconds(50);
    std::array<Duration, 2> ready{};
    Duration at{};
    for (const Step& step : *steps()) {  // made fit: each flash as soon as its lamps and the loop allow
      const auto lamps = static_cast<Lamps>(step.lamps);
      if (has_a(lamps)) at = std::max(at, ready[0]);
      if (has_b(lamps)) at = std::max(at, ready[1]);
      if (at >= config.plan.exposure) break;
      config.plan.code.push_back({at, lamps});
      if (has_a(lamps)) ready[0] = at + config.lamps.min_period;
      if (has_b(lamps)) ready[1] = at + config.lamps.min_period;
      at = at + microseconds(std::max(401, step.gap_us));
    }
    if (config.plan.code.empty()) config.plan.code.push_back({Duration{}, Lamps::both});
    RC_ASSERT(refusal(config.plan, config) == "");
    SequencerFixture bench(config);
    const MonoTime start = bench.fire();
    const auto freezes = *rc::gen::inRange(0, 3);
    for (int i = 0; i < freezes; ++i)
      bench.rig.freeze(start + milliseconds(260) + microseconds(*rc::gen::inRange(0, 100'000)),
                       microseconds(*rc::gen::inRange(1, 2'500)));
    bench.play();
    RC_ASSERT(bench.rig.all_inactive());
    const Duration late = config.tolerance.late;
    std::array<MonoTime, 2> last{kNoTime, kNoTime};
    for (const auto& set : bench.rig.sets) {
      if (set.output != Output::strobes || !set.active) continue;
      for (const std::size_t lamp : {0u, 1u}) {
        if (!known(last[lamp])) continue;
        const bool flashes = lamp == 0 ? has_a(set.lamps) : has_b(set.lamps);
        RC_ASSERT(set.time - last[lamp] >=
                  (flashes ? config.lamps.min_period : min_flash_interval(config)) - late);
      }
      if (has_a(set.lamps)) last[0] = set.time;
      if (has_b(set.lamps)) last[1] = set.time;
    }
    for (const FlashRecord& flash : bench.shot().flashes) {
      RC_ASSERT(known(flash.issue_start) || !bench.shot().abort_reason.empty());
      if (known(flash.issue_start))
        RC_ASSERT(flash.issue_start - flash.commanded <= config.tolerance.abort_late);
    }
    RC_CLASSIFY(bench.shot().abort_reason.empty(), "whole");
    RC_CLASSIFY(!bench.shot().abort_reason.empty(), "aborted");
  });
  CHECK_TRUE(holds);
}

TEST_GROUP(ShutterContact) {
  static Rig fitted() {
    Rig rig = shipped_rig();
    rig.plan.exposure = milliseconds(100);
    rig.plan.impact_at = milliseconds(50);
    rig.line(Line::xsync).fitted = true;
    return rig;
  }
  SequencerFixture bench{fitted()};
  void shoot() { bench.shoot(); }
};

TEST(ShutterContact, TellsWhenTheShutterReallyOpenedAndClosed) {
  bench.rig.xsync_works = true;
  bench.rig.opening_lag = milliseconds(49);
  bench.rig.closing_lag = milliseconds(58);
  shoot();
  const ShotRecord& shot = bench.shot();
  CHECK_EQUAL(ShutterFeedback::seen, shot.shutter_feedback);
  CHECK(known(shot.shutter_on) && known(shot.shutter_off));
  // The kernel's stamp is that of the line's change, the issue ends a little later.
  CHECK(shot.shutter_open - shot.shutter_on <= milliseconds(49));
  CHECK(shot.shutter_open - shot.shutter_on > milliseconds(49) - microseconds(1));
  CHECK(shot.shutter_close - shot.shutter_off > milliseconds(58) - microseconds(1));
  CHECK_EQUAL(2u, bench.rig.count(EventKind::xsync));
  CHECK_EQUAL(Line::xsync, bench.rig.find(EventKind::xsync)->line);
  CHECK_EQUAL(1, bench.rig.find(EventKind::xsync)->level);
  CHECK_EQUAL(0, bench.rig.find(EventKind::xsync, 1)->level);
}

TEST(ShutterContact, ThatSaysNothingIsMissedAndTheLagHasToDo) {
  shoot();
  CHECK_EQUAL(ShutterFeedback::missing, bench.shot().shutter_feedback);
  CHECK_EQUAL(bench.shot().shutter_on + bench.config.shutter.lag, bench.shot().shutter_open);
  CHECK_EQUAL(bench.shot().shutter_off + bench.config.shutter.lag, bench.shot().shutter_close);
}

TEST(ShutterContact, FarOffTheLagIsLate) {
  bench.rig.xsync_works = true;
  bench.rig.opening_lag = bench.config.shutter.lag + bench.config.shutter.late + milliseconds(1);
  shoot();
  CHECK_EQUAL(ShutterFeedback::late, bench.shot().shutter_feedback);
}

TEST(ShutterContact, IsWaitedForNoLongerThanItsTolerance) {
  bench.rig.xsync_works = true;
  bench.rig.closing_lag = milliseconds(400);
  shoot();
  const ShotRecord& shot = bench.shot();
  CHECK_EQUAL(ShutterFeedback::missing, shot.shutter_feedback);
  const MonoTime ended = bench.rig.find(EventKind::shot_ended)->device_time;
  CHECK(ended - shot.shutter_close < bench.config.shutter.late + milliseconds(1));
}

TEST(ShutterContact, MayBounce) {
  bench.rig.xsync_works = true;
  const MonoTime start = bench.fire();
  const MonoTime opened = start + bench.rig.opening_lag + milliseconds(310 - 50 - 45);
  for (const std::int64_t us : {300, 900}) {
    bench.rig.schedule({Input::xsync, opened + microseconds(us), false});
    bench.rig.schedule({Input::xsync, opened + microseconds(us + 200), true});
  }
  bench.play();
  CHECK_EQUAL(ShutterFeedback::seen, bench.shot().shutter_feedback);
  CHECK(bench.shot().shutter_open - bench.shot().shutter_on <= bench.rig.opening_lag);
  CHECK(bench.shot().shutter_close > bench.shot().shutter_off + milliseconds(44));
}

TEST(ShutterContact, ThatIsNotFittedIsNotMissed) {
  SequencerFixture without;
  without.shoot();
  CHECK_EQUAL(ShutterFeedback::none, without.shot().shutter_feedback);
}

TEST(ShutterContact, OfAnAbortedShotIsWaitedForWithTheOutputsSafe) {
  bench.rig.xsync_works = true;
  const MonoTime start = bench.fire(), pressed = start + milliseconds(310);
  bench.rig.schedule({Input::estop, pressed, true});
  while (bench.rig.time < pressed + milliseconds(1)) bench.step();
  CHECK(bench.rig.all_inactive());
  bench.play();
  CHECK_EQUAL(ShutterFeedback::seen, bench.shot().shutter_feedback);
  CHECK(bench.shot().shutter_close >= pressed);
}

TEST(ShutterContact, OfTheShotBeforeTellsNothingOfThisOne) {
  bench.rig.xsync_works = true;
  shoot();
  bench.rig.xsync_works = false;
  bench.shoot();
  CHECK_EQUAL(ShutterFeedback::seen, bench.shot(0).shutter_feedback);
  CHECK_EQUAL(ShutterFeedback::missing, bench.shot(1).shutter_feedback);
  CHECK_EQUAL(bench.shot(1).shutter_on + bench.config.shutter.lag, bench.shot(1).shutter_open);
}

TEST(ShutterContact, ThatClosesBeforeTheLineIsSetIsNotTheShutter) {
  bench.rig.xsync_works = true;
  bench.rig.opening_lag = milliseconds(49);
  const MonoTime start = bench.fire();
  bench.rig.schedule({Input::xsync, start - milliseconds(1), true});
  bench.play();
  CHECK_EQUAL(ShutterFeedback::seen, bench.shot().shutter_feedback);
  CHECK(bench.shot().shutter_open - bench.shot().shutter_on > milliseconds(48));
}
