// What goes wrong on the bench ends as a flagged readout or a clear message, never as a wrong number or a
// wait without end.
#include <fmt/format.h>

#include <string>
#include <vector>

#include "tests/hil/expect_ready.hpp"
#include "tests/hil/line_watcher.hpp"
#include "tests/hil/rig_fixture.hpp"
#include "tests/hil/truth_score.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe::hil;

namespace {

struct Shot {
  nlohmann::json readout;
  nlohmann::json truth;
};

std::string fault(const std::string& kind, int shot, const std::string& more = "") {
  return fmt::format("[[fault]]\nkind = \"{}\"\nshot = {}\n{}\n", kind, shot, more);
}

using Faults = std::vector<std::pair<std::string, std::string>>;  ///< their kinds, and what else is to say

/// One exposure for each of the faults: what was read of it beside what was true.
std::vector<Shot> fire_with(const Faults& faults) {
  RigFixtureOptions options;
  for (int shot = 0; const auto& [kind, more] : faults) options.scene_addition += fault(kind, ++shot, more);
  options.rig_edits = kShortExposure;  // the faults lie within three flashes of the impact
  options.seed = 7;
  options.sim_options = kFastTime;
  RigFixture bench(options);
  expect_ready(bench);
  std::vector<nlohmann::json> answers;
  std::string said;
  for (std::size_t i = 0; i < faults.size();
       ++i) {  // a series would end with the first shot that does not count
    const auto fired = strobe::testing::run_process(bench.fire(1, 0), kLongestWait);
    for (const auto& readout : readouts(fired.out)) answers.push_back(readout);
    said += fired.err;
  }
  std::vector<Shot> shots;
  for (const auto& readout : answers)
    for (const auto& truth : bench.truths())
      if (truth.at("shot_id") == readout.at("shot_id") && !truth.at("faults").empty())
        shots.push_back({readout, truth});
  CHECK_TEXT(shots.size() == faults.size(), (said + bench.log()).c_str());
  return shots;
}

bool has_no_rebound(const nlohmann::json& readout) {
  return readout.at("vx_td_mps").is_null() && readout.at("vx_lo_mps").is_null() && readout.at("e").is_null();
}

/// No number of any shot is wrong, whatever its flags; nulls are fine.
void expect_no_wrong_number(const std::vector<Shot>& shots) {
  TruthScore score;
  for (const Shot& shot : shots)
    if (shot.truth.at("ball").get<bool>())
      score.add(shot.readout, shot.truth, "shot " + shot.readout.at("shot_id").dump());
  CHECK_EQUAL("", score.beyond(4.5));
}

void expect_flag(const std::vector<Shot>& shots, const std::string& flag) {
  for (const Shot& shot : shots) CHECK_TEXT(has_flag(shot.readout, flag), shot.readout.dump().c_str());
}

std::string at(int flash_from_impact, const std::string& more = "lamp = \"both\"") {
  return fmt::format("flash_from_impact = {}\n{}", flash_from_impact, more);
}

}  // namespace

TEST_GROUP(Fault){};

TEST(Fault, ALateFlashIsFlaggedAndItsMeasuredTimeKeepsTheVelocitiesRight) {
  Faults faults;
  for (const int place : {-3, -2, -1, 1, 2, 3, -2, 2})
    faults.emplace_back("flash_late", at(place, "delay_us = 160\nlamp = \"both\""));
  const auto shots = fire_with(faults);
  expect_flag(shots, "late_flash");
  expect_no_wrong_number(shots);
  for (const Shot& each : shots)
    CHECK_TEXT(is_rejected(each.readout) || is_complete(each.readout), each.readout.dump().c_str());
}

TEST(Fault, AMissingFlashIsFlaggedAndMakesNoNumberWrong) {
  const auto shots =
      fire_with({{"flash_missing", at(-3)}, {"flash_missing", at(-1)}, {"flash_missing", at(2)}});
  expect_flag(shots, "missing_flash");
  expect_no_wrong_number(shots);
}

TEST(Fault, ADoubleFlashIsFlaggedAndMakesNoNumberWrong) {
  const std::string more = "delay_us = 400\nlamp = \"both\"";
  const auto shots = fire_with({{"flash_double", at(-2, more)}, {"flash_double", at(2, more)}});
  expect_flag(shots, "double_flash");
  expect_no_wrong_number(shots);
}

TEST(Fault, ABallThatMissesThePlateGivesNoNumbers) {
  for (const Shot& each : fire_with({{"ball_misses", ""}, {"machine_misfire", ""}})) {
    CHECK_TEXT(has_no_rebound(each.readout), each.readout.dump().c_str());
    CHECK_TEXT(!each.readout.at("flags").empty(), each.readout.dump().c_str());
  }
}

TEST(Fault, APhotographThatNeverComesIsSaidWhenTheFilesPatienceIsOver) {
  RigFixtureOptions options;
  options.scene_addition = fault("no_photograph", 0);
  options.rig_edits = {{"photograph_timeout_s = 5", "photograph_timeout_s = 1"}};
  RigFixture bench(options);
  expect_ready(bench);
  LineWatcher watch(bench.chip_dir());
  strobe::testing::Process fire = bench.start(bench.fire(1, 0));
  const std::int64_t closed = watch.wait_for("SHUTTER", 0, fire);
  CHECK(fire.wait_for_out("vx_td_mps", kLongestWait));
  const std::int64_t took = strobe::testing::monotonic_now_ns() - closed;
  CHECK_EQUAL(strobe::testing::ExitStatus({1, 0}), fire.wait(kLongestWait));
  const std::vector<nlohmann::json> answers = readouts(fire.out());
  LONGS_EQUAL(1, answers.size());
  CHECK(has_no_rebound(answers[0]));
  CHECK(has_flag(answers[0], "no_photograph"));
  CHECK_TEXT(took < 5'000'000'000, "as long as by a file that does not say");
}

TEST(Fault, AFrameThatComesAfterAllIsStillRead) {
  const auto shots = fire_with({{"frame_late", "delay_s = 1.0"}, {"frame_late", "delay_s = 2.0"}});
  expect_no_wrong_number(shots);
  for (const Shot& each : shots)
    CHECK_TEXT(is_rejected(each.readout) || is_complete(each.readout), each.readout.dump().c_str());
}

TEST(Fault, ADeadSensorOrLampIsFlaggedAndMakesNoNumberWrong) {
  const auto shots = fire_with({{"sensor_dead", "lamp = \"a\""}, {"lamp_dead", "lamp = \"b\""}});
  expect_flag(shots, "sensor_missing");
  expect_no_wrong_number(shots);
}

TEST(Fault, AnImageThatWasOverlookedMakesNoNumberWrong) {
  expect_no_wrong_number(fire_with({{"image_unseen", at(-2, "")},
                                    {"image_unseen", at(-1, "")},
                                    {"image_unseen", at(1, "")},
                                    {"image_unseen", at(2, "")}}));
}
