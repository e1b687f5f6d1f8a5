// A few sessions that are interrupted and gone on with. Nothing here judges time.
#include "tests/campaigns/resume.hpp"
#include "tests/campaigns/drawn_trials.hpp"

using namespace strobe::resume;

namespace {

void expect_nothing_missing(std::uint64_t seed, const Trial& trial) {
  strobe::campaigns::Draws draws(seed, 1);
  const auto verdict = run_trial(trial, draws);
  strobe::campaigns::expect_nothing_violated(verdict);
  CHECK(verdict.counts.at("fired") >= trial.shots);
}

}  // namespace

TEST_GROUP(Resume){};

TEST(Resume, NothingThatWasFiredIsMissingAndNothingCountsTwice) {
  for (const std::uint64_t seed : {1, 2}) expect_nothing_missing(seed, {2, 3});
}

TEST(Resume, NorAreShotsWhosePhotographsTheDeadLeftInTheCamerasFolder) {
  expect_nothing_missing(3, {2, 2, true});
}
