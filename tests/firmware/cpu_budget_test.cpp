#include "firmware/core/cpu_budget.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::firmware;

namespace {
constexpr MonoTime kStart = from_ns(5'000'000'000);
constexpr Duration kAhead = milliseconds(4);
constexpr Duration kSpin = microseconds(200);
}  // namespace

TEST_GROUP(CpuBudget) {
  CpuBudget budget{Rig::Tolerance{}};
  MonoTime now = kStart;

  void awake(Duration time) {
    for (Duration passed{}; passed < time; passed = passed + milliseconds(1)) {
      now = now + milliseconds(1);
      budget.note(now, milliseconds(1));
    }
  }
  void asleep(Duration time) {
    now = now + time;
    budget.note(now, {});
  }
  Duration ahead() const { return now - budget.wake_time(now); }
};

TEST(CpuBudget, LastsForAShotOfMoreThanEightHundredMilliseconds) {
  CHECK_EQUAL(kAhead, ahead());
  awake(milliseconds(870));
  CHECK_EQUAL(kAhead, ahead());
  awake(milliseconds(10));
  CHECK_EQUAL(kSpin, ahead());
}

TEST(CpuBudget, ComesBackAsTheSecondThatUsedItPasses) {
  awake(milliseconds(900));
  asleep(milliseconds(60));
  CHECK_EQUAL(kSpin, ahead());
  asleep(milliseconds(100));
  CHECK_EQUAL(kAhead, ahead());
  asleep(milliseconds(10'000));
  awake(milliseconds(870));
  CHECK_EQUAL(kAhead, ahead());
}

TEST(CpuBudget, BoundsTheTimeAwakeInEverySecond) {
  // Awake whenever it may be, for ten seconds; what counts is any second among them.
  std::array<bool, 10'000> was_awake{};
  for (bool& one : was_awake) {
    one = ahead() == kAhead;
    now = now + milliseconds(1);
    budget.note(now, one ? milliseconds(1) : Duration{});
  }
  int most = 0;
  for (std::size_t from = 0; from + 1000 <= was_awake.size(); ++from)
    most = std::max(most, static_cast<int>(std::count(
                              was_awake.begin() + static_cast<std::ptrdiff_t>(from),
                              was_awake.begin() + static_cast<std::ptrdiff_t>(from) + 1000, true)));
  CHECK_TRUE(most <= 931);  // 880 ms, a slot, and the step of a millisecond
  CHECK_TRUE(most >= 880);
}
