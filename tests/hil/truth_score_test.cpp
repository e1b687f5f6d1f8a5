#include "tests/hil/truth_score.hpp"

#include <random>
#include <string>

#include "tests/support/string_from.hpp"

using namespace strobe::hil;

namespace {

nlohmann::json readout_with(double e, double sd) {
  return {{"e", e}, {"mu", nullptr}, {"sd", {{"e", sd}}}, {"flags", nlohmann::json::array()}};
}

const nlohmann::json kTruth{{"readout", {{"e", 0.75}, {"mu", 0.5}}}};

/// Shots whose true noise is `ratio` times what they state.
TruthScore shots_with_noise(double ratio, int count) {
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0.0, 0.01 * ratio);
  TruthScore score;
  for (int i = 0; i < count; ++i) score.add(readout_with(0.75 + noise(random), 0.01), kTruth, "shot");
  return score;
}

}  // namespace

TEST_GROUP(TruthScore){};

TEST(TruthScore, NamesANumberThatIsOffByMoreThanItsSdAllows) {
  TruthScore score;
  score.add(readout_with(0.80, 0.01), kTruth, "shot 1");
  CHECK(score.beyond(4.5).find("shot 1: e is off by 5.00 sd") != std::string::npos);
  CHECK_EQUAL("", score.beyond(5.1));
}

TEST(TruthScore, TakesANumberWithoutAnSdForWrong) {
  TruthScore score;
  score.add(readout_with(0.75, 0.0), kTruth, "shot 1");
  CHECK(!score.beyond(1e9).empty());
}

TEST(TruthScore, TellsTheRmsOfWhatWasMeasured) {
  TruthScore score;
  score.add(readout_with(0.76, 0.01), kTruth, "shot 1");
  score.add(readout_with(0.68, 0.01), kTruth, "shot 2");
  DOUBLES_EQUAL(5.0, score.rms_of("e").value(), 1e-9);  // of 1 and -7
  CHECK_FALSE(score.rms_of("mu").has_value());
}

TEST(TruthScore, AcceptsErrorsAsLargeAsStated) {
  CHECK_EQUAL("", shots_with_noise(1.0, 60).implausible_rms(1e-3));
}

TEST(TruthScore, RejectsStatedSdsThatAreTooSmallOrTooLarge) {
  // With 60 shots and one quantity the bounds are about 0.70 and 1.32.
  CHECK(!shots_with_noise(1.6, 60).implausible_rms(1e-3).empty());
  CHECK(!shots_with_noise(0.5, 60).implausible_rms(1e-3).empty());
}

TEST(TruthScore, DoesNotJudgeWhatWasNotMeasured) {
  TruthScore score;
  score.add(readout_with(0.75, 0.01), kTruth, "shot 1");
  CHECK_EQUAL(std::string::npos, score.table().find("mu"));
}
