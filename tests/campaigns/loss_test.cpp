// The shipped programs across a link that loses, and killed in the middle of shots. Nothing here judges time.
#include "tests/campaigns/loss.hpp"
#include "tests/campaigns/drawn_trials.hpp"

using namespace strobe::loss;

namespace {

std::map<std::string, double> expect_nothing_lost(const Trial& trial) {
  strobe::campaigns::Draws draws(1, 1);
  const auto verdict = run_trial(trial, draws);
  strobe::campaigns::expect_nothing_violated(verdict);
  LONGS_EQUAL(0, verdict.counts.at("missing events"));
  LONGS_EQUAL(trial.kills, verdict.counts.at("kills"));
  return verdict.counts;
}

}  // namespace

TEST_GROUP(Loss){};

TEST(Loss, OfAFifthWithDoublesAndLatecomersLeavesNothingMissingInTheEnd) {
  const auto counts = expect_nothing_lost({"", Victim::nobody, {0.2, 0.1, 0.2, 60}});
  CHECK(counts.at("packets lost") > 10 && counts.at("packets doubled") > 5 &&
        counts.at("packets delayed") > 10);
}

TEST(Loss, OfTheWholeLinkForAWhileInTheMiddleOfAShotLeavesNothingMissingInTheEnd) {
  CHECK(expect_nothing_lost({.cut_s = 1.5}).at("packets cut") > 0);
}

TEST(Loss, OfTheHostInTheMiddleOfShotsLeavesNothingMissingInItsFolder) {
  expect_nothing_lost({.victim = Victim::host, .kills = 2});
}

TEST(Loss, OfTheFirmwareInTheMiddleOfShotsLeavesNothingMissingAndTheShotsNamed) {
  CHECK(expect_nothing_lost({.victim = Victim::firmware, .kills = 2}).at("boots") >= 3);
}

TEST(Loss, IsTriedOnEachLinkInTurnsAndOnBothSides) {
  CHECK_EQUAL(std::string("no loss"), drawn({}, {1, 1}).name);
  CHECK(drawn({}, {1, 9}).cut_s == 10.0 && drawn({}, {1, 9}).faults.loss == 0.2);
  CHECK(drawn({}, {1, 10}).victim == Victim::host && drawn({}, {1, 10}).kills == 100);
  CHECK(drawn({}, {1, 11}).victim == Victim::firmware);
  CHECK(drawn({.links = true}, {1, 10}).victim == Victim::nobody);
  CHECK(drawn({.kills = 5}, {1, 1}).victim == Victim::host);
}
