// The shipped programs across a link that loses, and killed in the middle of shots. Nothing here judges time.
#include "tests/campaigns/loss.hpp"
#include "tests/campaigns/drawn_trials.hpp"

using namespace strobe::loss;

namespace {

Outcome expect_nothing_lost(const Trial& trial) {
  strobe::campaigns::Draws draws(1, 1);
  const Outcome outcome = run_trial(trial, draws);
  strobe::campaigns::expect_nothing_violated(outcome);
  LONGS_EQUAL(0, outcome.audit.missing);
  LONGS_EQUAL(trial.kills, outcome.kills);
  return outcome;
}

}  // namespace

TEST_GROUP(Loss){};

TEST(Loss, OfAFifthWithDoublesAndLatecomersLeavesNothingMissingInTheEnd) {
  const LinkCounts link = expect_nothing_lost({"", Victim::nobody, {0.2, 0.1, 0.2, 60}}).link;
  CHECK(link.lost > 10 && link.doubled > 5 && link.delayed > 10);
}

TEST(Loss, OfTheWholeLinkForAWhileInTheMiddleOfAShotLeavesNothingMissingInTheEnd) {
  CHECK(expect_nothing_lost({.cut_s = 1.5}).link.cut > 0);
}

TEST(Loss, OfTheHostInTheMiddleOfShotsLeavesNothingMissingInItsFolder) {
  expect_nothing_lost({.victim = Victim::host, .kills = 2});
}

TEST(Loss, OfTheFirmwareInTheMiddleOfShotsLeavesNothingMissingAndTheShotsNamed) {
  CHECK(expect_nothing_lost({.victim = Victim::firmware, .kills = 2}).audit.boots >= 3);
}

TEST(Loss, IsTriedOnEachLinkInTurnsAndOnBothSides) {
  CHECK_EQUAL(std::string("no loss"), drawn({}, {1, 1}).name);
  CHECK(drawn({}, {1, 9}).cut_s == 10.0 && drawn({}, {1, 9}).faults.loss == 0.2);
  CHECK(drawn({}, {1, 10}).victim == Victim::host && drawn({}, {1, 10}).kills == 100);
  CHECK(drawn({}, {1, 11}).victim == Victim::firmware);
  CHECK(drawn({.links = true}, {1, 10}).victim == Victim::nobody);
  CHECK(drawn({.kills = 5}, {1, 1}).victim == Victim::host);
}
