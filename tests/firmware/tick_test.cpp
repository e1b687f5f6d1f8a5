#include <algorithm>
#include <rapidcheck.h>
#include <vector>

#include "firmware/core/tick.hpp"
#include "tests/support/sequencer_fixture.hpp"
#include "tests/support/string_from.hpp"
#include "tests/support/virtual_rig.hpp"

using namespace strobe;
using namespace strobe::firmware;

TEST_GROUP(Tick) {
  static constexpr Duration kPeriod = milliseconds(4);
  static constexpr int kPeriods = 15;
  std::vector<Gap> gaps;

  /// One gap in each of the first so many periods, at a phase, with a little jitter.
  void ticks(int count, Duration phase, Duration length) {
    for (int k = 0; k < count; ++k) {
      const Duration jitter = nanoseconds((k * 7919) % 9000);
      gaps.push_back({from_ns(1'000'000'000'000) + kPeriod * k + phase + jitter, length + jitter});
    }
  }
  Tick found() const { return detect_tick(gaps, kPeriod, kPeriods); }
};

TEST(Tick, IsUnknownWhereNothingInterrupts) { CHECK_FALSE(found().known()); }

TEST(Tick, IsFoundAtItsPhase) {
  ticks(kPeriods, microseconds(1234), microseconds(18));
  const Tick tick = found();
  CHECK_TRUE(tick.known());
  CHECK_EQUAL(kPeriod, tick.period);
  CHECK_EQUAL(microseconds(1234), tick.phase);
  const auto shorter =
      std::count_if(gaps.begin(), gaps.end(), [&](const Gap& gap) { return gap.length < tick.length; });
  CHECK_EQUAL(kPeriods * 9 / 10, shorter);
}

TEST(Tick, IsFoundAcrossTheEndOfAPeriod) {
  ticks(kPeriods, kPeriod - microseconds(3), microseconds(18));
  CHECK_EQUAL(kPeriod - microseconds(3), found().phase);
}

TEST(Tick, IsFoundThoughSomePeriodsDoNotShowIt) {
  ticks(9, microseconds(500), microseconds(20));
  CHECK_TRUE(found().known());
  gaps.pop_back();
  CHECK_FALSE(found().known());
}

TEST(Tick, IsFoundAmongOtherInterruptions) {
  for (int k = 0; k < 200; ++k) gaps.push_back({from_ns(1'000'000'000'000 + k * 293'117LL), microseconds(3)});
  ticks(kPeriods, microseconds(3000), microseconds(20));
  const Tick tick = found();
  CHECK_TRUE(tick.known());
  CHECK(tick.phase >= microseconds(2960) && tick.phase <= microseconds(3000));
}

TEST(Tick, IsNotMadeOfInterruptionsWithoutAPhase) {
  for (int k = 0; k < 60; ++k)
    gaps.push_back({from_ns(1'000'000'000'000 + k * 1'013'117LL), microseconds(20)});
  CHECK_FALSE(found().known());
}

TEST(Tick, IsNotMadeOfManyInterruptionsInOnePeriod) {
  for (int k = 0; k < 30; ++k) gaps.push_back({from_ns(1'000'000'000'000 + k * 1'000LL), microseconds(2)});
  CHECK_FALSE(found().known());
}

using namespace strobe;
using namespace strobe::firmware;

namespace {

const Tick kTick{milliseconds(4), microseconds(700), microseconds(20)};

PulseSchedule train(Duration first, Duration period, int count) {
  PulseSchedule plan;
  for (int k = 0; k < count; ++k)
    plan.pulses.push_back({first + period * k, Output::strobes, microseconds(50), k});
  return plan;
}

Duration distance_to_tick(MonoTime at, const Tick& tick) {
  const Duration after = ((at - MonoTime{tick.phase}) % tick.period + tick.period) % tick.period;
  return std::min(after, tick.period - after);
}

Duration nearest(MonoTime start, const PulseSchedule& plan, const Tick& tick) {
  Duration least = tick.period;
  for (const PlannedPulse& pulse : plan.pulses)
    if (pulse.output == Output::strobes) least = std::min(least, distance_to_tick(start + pulse.at, tick));
  return least;
}

}  // namespace

TEST_GROUP(TickAvoidance){};

TEST(TickAvoidance, ChangesNothingWithoutATickOrAFlash) {
  CHECK_EQUAL(Duration{}, TickAvoidance({}).delay(from_ns(123), train({}, milliseconds(3), 5)));
  CHECK_EQUAL(Duration{}, TickAvoidance(kTick).delay(from_ns(123), PulseSchedule{}));
}

TEST(TickAvoidance, LeavesAShotAloneThatIsWellPlacedAlready) {
  const TickAvoidance quiet(kTick);
  const PulseSchedule plan = train(milliseconds(60), milliseconds(3), 100);
  const MonoTime earliest = from_ns(777'000'000);
  const MonoTime start = earliest + quiet.delay(earliest, plan);
  CHECK_EQUAL(Duration{}, quiet.delay(start, plan));
}

TEST(TickAvoidance, LooksAtFlashesOnly) {
  PulseSchedule plan;
  plan.pulses.push_back({milliseconds(5), Output::shutter, milliseconds(500), -1});
  CHECK_EQUAL(Duration{}, TickAvoidance(kTick).delay(MonoTime{} + kTick.phase, plan));
}

// 3 ms and 4 ms: the flashes fall on a grid of 1 ms relative to the tick, whose middle is 500 us away. The
// tick's end and margins move the best place by less than 40 us, a step is 31 us.
TEST(TickAvoidance, PutsATrainOfThreeMillisecondsMidwayBetweenTicksOfFour) {
  CHECK_TRUE(rc::check("wherever it would start", [] {
    const MonoTime earliest = from_ns(*rc::gen::inRange<std::int64_t>(0, 1'000'000'000'000));
    const PulseSchedule plan = train(milliseconds(60), milliseconds(3), 167);
    const Duration delay = TickAvoidance(kTick).delay(earliest, plan);
    RC_ASSERT(delay.count() >= 0 && delay < kTick.period);
    RC_ASSERT(nearest(earliest + delay, plan, kTick) >= microseconds(420));
  }));
}

// A tick that takes 20 us, with the margins of 10 us, hides 2 % of a period: a few flashes always find a
// place.
TEST(TickAvoidance, FindsAPlaceForAnyFewFlashes) {
  CHECK_TRUE(rc::check("for up to ten flashes", [] {
    const auto count = *rc::gen::inRange(1, 11);
    PulseSchedule plan;
    for (int k = 0; k < count; ++k) {
      const Duration at = nanoseconds(*rc::gen::inRange<std::int64_t>(0, 100'000'000));
      plan.pulses.push_back({at, Output::strobes, microseconds(50), k});
    }
    const MonoTime earliest = from_ns(*rc::gen::inRange<std::int64_t>(0, 1'000'000'000'000));
    const Duration delay = TickAvoidance(kTick).delay(earliest, plan);
    RC_ASSERT(nearest(earliest + delay, plan, kTick) >= microseconds(10));
  }));
}

TEST(TickAvoidance, MovesTheShotOfARunningSequencer) {
  testing::SequencerFixture bench(testing::shipped_rig(), kTick);
  const MonoTime earliest = bench.shoot(true);
  const ShotRecord& shot = bench.shot();
  CHECK(shot.start >= earliest && shot.start < earliest + kTick.period);
  CHECK_TRUE(shot.abort_reason.empty());
  CHECK(shot.flashes.size() > 100);
  for (const FlashRecord& flash : shot.flashes)
    CHECK(distance_to_tick(flash.commanded, kTick) >= microseconds(420));
}
