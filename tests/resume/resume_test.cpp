// A few sessions that are interrupted and gone on with; the many are tests/resume/run's. Nothing here judges time.
#include <string>

#include "tests/resume/trial.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::resume;

namespace {

void expect_nothing_missing(const Trial& trial) {
  const Verdict verdict = run_trial(trial);
  std::string words;
  for (const std::string& violation : verdict.violations) words += violation + "\n";
  words += verdict.happened + "\n" + verdict.words;
  CHECK_TEXT(verdict.violations.empty(), words.c_str());
  CHECK(verdict.fired >= trial.shots);
}

}  // namespace

TEST_GROUP(Resume){};

TEST(Resume, NothingThatWasFiredIsMissingAndNothingCountsTwice) {
  for (const std::uint64_t seed : {1, 2}) expect_nothing_missing({seed, 2, 3, false});
}

TEST(Resume, NorAreShotsWhosePhotographsTheDeadLeftInTheCamerasFolder) {
  expect_nothing_missing({3, 2, 2, true});
}
