#include "firmware/linux/hang_judge.hpp"

// CppUTest redefines new; its headers come last.
#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::firmware;
using Verdict = HangJudge::Verdict;

namespace {
constexpr MonoTime kNow{100'000'000'000};
constexpr Duration kLook = milliseconds(100);
}  // namespace

TEST_GROUP(HangJudge) { HangJudge judge; };

TEST(HangJudge, FindsNothingInThreadsThatTurnOrHaveNotBegun) {
  for (int look = 0; look < 3; ++look) {
    CHECK(judge.look({}, kNow) == Verdict::well);
    CHECK(judge.look({kNow - milliseconds(60), kNow - milliseconds(600)}, kNow) == Verdict::well);
  }
}

TEST(HangJudge, SaysThatTheLoopHangsAtTheSecondLook) {
  const MonoTime stood = kNow - HangJudge::kLoopHangs - nanoseconds(1);
  CHECK(judge.look({stood, kNow}, kNow) == Verdict::well);
  CHECK(judge.look({stood, kNow}, kNow + kLook) == Verdict::loop_hangs);
}

TEST(HangJudge, GivesTheLoopItsTurnAfterTheWholeMachineStoodStill) {
  CHECK(judge.look({kNow - milliseconds(3'000), kNow}, kNow) == Verdict::well);
  CHECK(judge.look({kNow + milliseconds(50), kNow}, kNow + kLook) == Verdict::well);
  CHECK(judge.look({kNow - milliseconds(3'000), kNow}, kNow + kLook * 2) == Verdict::well);
}

TEST(HangJudge, HasPatienceWithAPublisherOnASlowDisk) {
  const MonoTime stood = kNow - milliseconds(9'000);
  for (int look = 0; look < 3; ++look) CHECK(judge.look({kNow, stood}, kNow) == Verdict::well);
  judge.look({kNow, stood}, kNow + milliseconds(1'500));
  CHECK(judge.look({kNow + milliseconds(1'500), stood}, kNow + milliseconds(1'600)) ==
        Verdict::publisher_hangs);
}

TEST(HangJudge, TakesTheLoopMoreSeriously) {
  const MonoTime stood = kNow - milliseconds(20'000);
  judge.look({stood, stood}, kNow);
  CHECK(judge.look({stood, stood}, kNow) == Verdict::loop_hangs);
}

TEST(HangJudge, IsDoneWithThePublisherBeforeTheServiceManagerLosesPatience) {
  CHECK(HangJudge::publisher_limit(milliseconds(0)) == HangJudge::kPublisherHangs);
  CHECK(HangJudge::publisher_limit(milliseconds(4'000)) == milliseconds(2'000));
  CHECK(HangJudge::publisher_limit(milliseconds(60'000)) == HangJudge::kPublisherHangs);
}
