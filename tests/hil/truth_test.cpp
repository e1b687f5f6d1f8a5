// Truth against readout: what the simulated bench did, and what the shipped programs say about it.
#include <fmt/format.h>

#include <cstdio>
#include <random>
#include <string>
#include <vector>

#include "tests/hil/rig_fixture.hpp"
#include "tests/hil/truth_score.hpp"
#include "tests/support/string_from.hpp"

using namespace strobe::hil;
using namespace std::chrono_literals;

namespace {

constexpr int kShots = 2;

const std::vector<std::string> kConditions{"zero_17", "zero_23", "zero_34", "zero_41", "zero_49", "zero_60",
                                           "zero_68", "top_18",  "top_23",  "top_34",  "top_42",  "top_48",
                                           "top_61",  "top_71",  "back_17", "back_22", "back_35", "back_40",
                                           "back_45", "back_59", "back_68"};

const nlohmann::json* truth_of(const std::vector<nlohmann::json>& truths, int shot_id) {
  for (const auto& truth : truths)
    if (truth.at("shot_id").get<int>() == shot_id) return &truth;
  return nullptr;
}

struct Tally {
  TruthScore score;
  std::string trouble;
};

void score_condition(const std::string& condition, std::uint64_t seed, Tally& tally) {
  RigFixtureOptions options;
  options.scene = condition;
  options.seed = seed;
  options.rig_edits = kShortExposure;
  options.sim_options = kFastTime;
  RigFixture bench(options);
  if (!bench.ready()) {
    tally.trouble += fmt::format("\n  {}: strobed did not come up:\n{}", condition, bench.log());
    return;
  }
  const auto fired = strobe::testing::run_process(bench.fire(kShots, 0), kLongestWait);
  if (fired.status != strobe::testing::ExitStatus({0, 0}))
    tally.trouble += fmt::format("\n  {}: strobe fire did not end well: {}", condition, fired.err);
  int good = 0;
  for (const auto& readout : readouts(fired.out)) {
    const int shot_id = readout.at("shot_id").get<int>();
    const std::vector<nlohmann::json> truths = bench.truths();
    const nlohmann::json* truth = truth_of(truths, shot_id);
    if (is_rejected(readout) || !is_complete(readout) || truth == nullptr) {
      tally.trouble += fmt::format("\n  {} shot {}: {}", condition, shot_id, readout.dump());
      continue;
    }
    tally.score.add(readout, *truth, fmt::format("{} shot {}", condition, shot_id));
    ++good;
  }
  if (good < kShots) tally.trouble += fmt::format("\n  {}: {} good shots", condition, good);
}

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

TEST_GROUP(Truth){};

TEST(Truth, EveryNumberOfEveryConditionIsRightWithinItsStatedUncertainty) {
  Tally tally;
  std::uint64_t seed = 100;
  for (const std::string& condition : kConditions) score_condition(condition, ++seed, tally);
  std::printf("%sshots %zu\n", tally.score.table().c_str(), tally.score.shots());
  CHECK_EQUAL("", tally.trouble);
  // 670 numbers of 16 kinds: the chance of any normal error beyond 4.5 is 0.5 %.
  CHECK_EQUAL("", tally.score.beyond(4.5));
  CHECK_EQUAL("", tally.score.implausible_rms(1e-3));
}

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
