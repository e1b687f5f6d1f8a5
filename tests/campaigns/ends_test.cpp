// A few ends of the shipped firmware; a campaign of thousands also judges by the millisecond.
#include "tests/campaigns/ends.hpp"
#include "tests/campaigns/drawn_trials.hpp"

using namespace strobe::ends;
using strobe::campaigns::Draws;
using strobe::campaigns::expect_nothing_violated;

TEST_GROUP(Ends){};

TEST(Ends, ADebuggerThatHoldsAThreadOfTheWorkerKeepsNoOutputActive) {
  // Its first thread, and its loop.
  for (const int thread : {0, 1})
    expect_nothing_violated(run_trial({Victim::worker, FaultKind::held_thread, thread, Moment::flash, 5}));
}

TEST(Ends, OfAWorkerAreSeenByAGuardianThatMayHaveNoMoreDescriptors) {
  const auto verdict = run_trial({Victim::both, FaultKind::no_descriptors, 0, Moment::flash, 5});
  expect_nothing_violated(verdict);
  CHECK_TRUE_TEXT(verdict.counts.at("ended strobed") + verdict.counts.at("not possible") > 0,
                  verdict.words.c_str());
}

TEST(Ends, OfTheThreadThatIsMakingTheOutputsInactiveDoNotKeepTheGuardianFromIt) {
  // The first of the worker's five threads, then the last of the guardian's three, which learns of it: one of three
  // comes while that one holds the outputs.
  for (int again = 0; again < 6; ++again)
    expect_nothing_violated(
        run_trial({Victim::both, FaultKind::ended_thread, 5, Moment::trigger_on, 1, 4000, false}));
}

TEST(Ends, LeaveNoOutputActiveAndNoEventLost) {
  constexpr int kTrials = 16;
  int done = 0;
  expect_nothing_violated("ends", kTrials, [&done](Draws& draws) {
    const auto verdict = run_trial(drawn(draws));
    done += verdict.counts.at("not possible") == 0 ? 1 : 0;
    return verdict;
  });
  CHECK(done > kTrials / 2);
}
