// The shipped programs across a link that loses, and killed in the middle of shots: a few of each, for the
// many are tests/loss/run's. Nothing here judges time.
#include <string>

#include "tests/loss/trials.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::loss;

namespace {

void expect_nothing_lost(const TrialResult& result) {
  std::string violations;
  for (const std::string& violation : result.audit.violations) violations += violation + "\n";
  const std::string words = violations + result.words;
  CHECK_TEXT(violations.empty(), words.c_str());
  CHECK_TEXT(result.fired, words.c_str());
  CHECK(result.audit.journalled > 0);
  LONGS_EQUAL(0, result.audit.missing);
}

TrialResult expect_kills_survived(Victim victim) {
  KillTrial trial;
  trial.victim = victim;
  trial.kills = 2;
  const TrialResult result = run_trial(trial);
  LONGS_EQUAL(trial.kills, result.kills);
  expect_nothing_lost(result);
  return result;
}

}  // namespace

TEST_GROUP(Loss){};

TEST(Loss, OfAFifthWithDoublesAndLatecomersLeavesNothingMissingInTheEnd) {
  LinkTrial trial;
  trial.faults = {0.2, 0.1, 0.2, 60};
  const TrialResult result = run_trial(trial);
  CHECK(result.link.lost > 10 && result.link.doubled > 5 && result.link.delayed > 10);
  expect_nothing_lost(result);
}

TEST(Loss, OfTheWholeLinkForAWhileInTheMiddleOfAShotLeavesNothingMissingInTheEnd) {
  LinkTrial trial;
  trial.cut_s = 1.5;
  const TrialResult result = run_trial(trial);
  CHECK(result.link.cut > 0);
  expect_nothing_lost(result);
}

TEST(Loss, OfTheHostInTheMiddleOfShotsLeavesNothingMissingInItsFolder) {
  expect_kills_survived(Victim::host);
}

TEST(Loss, OfTheFirmwareInTheMiddleOfShotsLeavesNothingMissingAndTheShotsNamed) {
  const TrialResult result = expect_kills_survived(Victim::firmware);
  CHECK(result.audit.boots >= 3);
}
