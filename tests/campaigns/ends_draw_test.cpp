// Which ends are drawn.
#include <csignal>
#include <set>
#include <string>

#include "tests/campaigns/ends.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::ends;

TEST_GROUP(DrawnEnds){};

TEST(DrawnEnds, HaveEverySignalForEveryVictimAtEveryMoment) {
  std::set<std::string> signals, moments;
  for (int number = 1; number <= 5'000; ++number) {
    const Trial trial = drawn({1, number});
    if (trial.fault == FaultKind::signal) signals.insert(describe_fault(trial));
    moments.insert(name(trial.moment));
  }
  LONGS_EQUAL(3 * 64 - 1, signals.size());  // SIGSTOP of both is what hardware limits are for
  LONGS_EQUAL(6, moments.size());
}

TEST(DrawnEnds, LeaveOneProcessToAct) {
  for (int number = 1; number <= 5'000; ++number) {
    const Trial trial = drawn({2, number});
    const bool stops =
        trial.fault == FaultKind::stop || (trial.fault == FaultKind::signal && trial.argument == SIGSTOP);
    CHECK(!stops || trial.victim != Victim::both);
    CHECK(trial.fault != FaultKind::removed_chip || !trial.keeps);
  }
}

TEST(DrawnEnds, LetEachSystemCallFailInSeveralWays) {
  std::set<std::string> calls, words;
  for (int argument = 0; argument < 1000; ++argument) {
    calls.insert(failing_call(argument).name);
    words.insert(failing_call(argument).words());
  }
  CHECK(words.size() == 7 * calls.size());
}
