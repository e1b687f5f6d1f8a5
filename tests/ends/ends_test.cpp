// A few drawn ends of the shipped firmware; the thousands are tests/ends/run's, which also judges by the millisecond.
#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>
#include <random>
#include <string>

#include "tests/ends/trial.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::ends;

namespace {

constexpr int kTrials = 16;

}  // namespace

TEST_GROUP(Ends){};

TEST(Ends, ADebuggerThatHoldsAThreadOfTheWorkerKeepsNoOutputActive) {
  // Its first thread, and its loop.
  for (const int thread : {0, 1}) {
    const Trial trial{Victim::worker, FaultKind::held_thread, thread, Moment::flash, 5};
    const Outcome outcome = run_trial(trial);
    for (const std::string& violation : outcome.violations)
      FAIL(fmt::format("{} (thread {})\n{}", violation, thread, outcome.log).c_str());
  }
}

TEST(Ends, OfAWorkerAreSeenByAGuardianThatMayHaveNoMoreDescriptors) {
  const Trial trial{Victim::both, FaultKind::no_descriptors, 0, Moment::flash, 5};
  const Outcome outcome = run_trial(trial);
  CHECK_TRUE_TEXT(outcome.violations.empty(), outcome.log.c_str());
  CHECK_TRUE_TEXT(outcome.ended || !outcome.done, outcome.log.c_str());
}

TEST(Ends, OfTheThreadThatIsMakingTheOutputsInactiveDoNotKeepTheGuardianFromIt) {
  // The first of the worker's five threads, then the last of the guardian's three, which learns of it: one of three
  // comes while that one holds the outputs.
  for (int again = 0; again < 6; ++again) {
    const Outcome outcome =
        run_trial({Victim::both, FaultKind::ended_thread, 5, Moment::trigger_on, 1, 4000, false});
    for (const std::string& violation : outcome.violations)
      FAIL(fmt::format("{}\n{}", violation, outcome.log).c_str());
  }
}

TEST(Ends, LeaveNoOutputActiveAndNoEventLost) {
  const char* const repeated = std::getenv("STROBE_ENDS_SEED");
  const std::uint64_t seed = repeated != nullptr ? std::stoull(repeated) : std::random_device{}();
  std::printf("STROBE_ENDS_SEED=%llu repeats this\n", static_cast<unsigned long long>(seed));
  int done = 0;
  for (int number = 1; number <= kTrials; ++number) {
    const Trial trial = drawn_trial(seed, number);
    const Outcome outcome = run_trial(trial);
    done += outcome.done ? 1 : 0;
    for (const std::string& violation : outcome.violations)
      FAIL(fmt::format("{} ({}; strobe-ends --seed {} --only {})\n{}", violation, describe(trial), seed,
                       number, outcome.log)
               .c_str());
  }
  CHECK(done > kTrials / 2);
}
