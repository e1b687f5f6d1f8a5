// Truth against readout: what the simulated bench did, and what the shipped programs say about it.
#include <fmt/format.h>

#include <cstdio>
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
