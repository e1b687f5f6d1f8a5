#include "firmware/core/tick.hpp"

#include <algorithm>
#include <vector>

#include "tests/support/string_from.hpp"

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
