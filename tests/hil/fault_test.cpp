// What goes wrong on the bench ends as a flagged readout or a clear message, never as a wrong number or a
// wait without end.
#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/hil/line_changes.hpp"
#include "tests/hil/raw_host.hpp"
#include "tests/hil/truth_score.hpp"

#include "tests/hil/expectations.hpp"
#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::hil;
using namespace strobe::testing;
using Faults = std::vector<std::pair<std::string, std::string>>;  ///< their kinds, and what else is to say

namespace {

struct Shot {
  nlohmann::json readout;
  nlohmann::json truth;
};

std::string fault(const std::string& kind, int shot, const std::string& more = "") {
  return fmt::format("[[fault]]\nkind = \"{}\"\nshot = {}\n{}\n", kind, shot, more);
}

/// One exposure for each of the faults: what was read of it beside what was true.
std::vector<Shot> fire_with(const Faults& faults) {
  RigFixtureOptions options;
  for (int shot = 0; const auto& [kind, more] : faults) options.scene_addition += fault(kind, ++shot, more);
  options.rig_edits = kShortExposure;  // the faults lie within three flashes of the impact
  options.seed = 7;
  options.sim_options = kFastTime;
  ReadyRig bench(options);
  std::vector<nlohmann::json> answers;
  std::string said;
  for (std::size_t i = 0; i < faults.size();
       ++i) {  // a series would end with the first shot that does not count
    const auto fired = run_process(bench.fire(1, 0), kLongestWait);
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

constexpr int kKernelBuffer = 1024;  // of all inputs with libgpiod 2; 16 a line with 1.6
constexpr int kFlood = kKernelBuffer + 100;
constexpr int kOthers =
    10;  // edges of the rig's own sensors meanwhile, at most: the flashes are 100 ms apart

/// Time enough between two flashes to be stopped, flooded and woken.
RigFixtureOptions slow_train() {
  RigFixtureOptions options;
  options.rig_edits = {{"period_us = 3000", "period_us = 100000"},
                       {"shutter_open_ms = 500", "shutter_open_ms = 1500"},
                       {"impact_at_ms = 250", "impact_at_ms = 700"}};
  return options;
}

/// A process is stopped by its first thread, which on a busy machine comes late to it; the others go on until
/// then.
bool stands_still(pid_t pid) {
  const std::filesystem::directory_iterator threads("/proc/" + std::to_string(pid) + "/task");
  return std::all_of(begin(threads), end(threads), [](const auto& thread) {
    const std::string stat = read_text(thread.path() / "stat");
    return stat.find(") T ") != std::string::npos;
  });
}

/// Stops whoever reads edges just after the third flash, and makes it miss some. False: the shot ended
/// before.
bool flood_in_mid_train(const RigFixture& bench, Process& fire) {
  LineWatcher watch(bench.chip_dir());
  for (int flash = 0; flash < 3; ++flash)
    if (watch.wait_for("STROBE_A", 1, fire) == 0) return false;
  const pid_t reader = bench.worker();
  watch.hold_time();  // a reader that is stopped for too long makes its next flash late
  kill(reader, SIGSTOP);
  CHECK(wait_until([&] { return stands_still(reader); }, kLongestWait));
  watch.drive("SENSOR_A", 0);  // the flash's own pulse may hold it, and the first edge would be none
  for (int i = 0; i < kFlood; ++i)
    for (const int level : {1, 0}) watch.drive("SENSOR_A", level);
  kill(reader, SIGCONT);
  watch.release_time();
  return true;
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
  ReadyRig bench(options);
  LineWatcher watch(bench.chip_dir());
  Process fire = bench.start(bench.fire(1, 0));
  const std::int64_t closed = watch.wait_for("SHUTTER", 0, fire);
  CHECK(fire.wait_for_out("vx_td_mps", kLongestWait));
  const std::int64_t took = watch.now_ns() - closed;
  CHECK_EQUAL(ExitStatus({1, 0}), fire.wait(kLongestWait));
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

// Edges that the kernel had no room for are told by the shot in which they were lost, and by no other.

TEST_GROUP(LostEdges){};

TEST(LostEdges, AreToldByTheShotWhoseReaderStoodStill) {
  ReadyRig bench(slow_train());
  Process fire = bench.start(bench.fire(1, 0));
  CHECK_TEXT(flood_in_mid_train(bench, fire), bench.log().c_str());
  CHECK(fire.wait(kLongestWait).has_value());
  const auto flooded = readouts(fire.out()).at(0);
  CHECK_TEXT(has_flag(flooded, "events_missing"), flooded.dump().c_str());
  const auto next = run_process(bench.fire(1, 0), kLongestWait);
  CHECK_TEXT(!has_flag(readouts(next.out).at(0), "events_missing"), next.out.c_str());
  const auto shots = read_log(bench.journal()).shots;
  LONGS_EQUAL(2, shots.size());
  // 1.6 tells that a buffer was full, 2 counts what is missing.
  const std::int64_t lost = shots[0].kernel_overflows;
  CHECK_TEXT(lost == 1 || (lost >= kFlood - kKernelBuffer && lost <= kFlood - kKernelBuffer + kOthers),
             std::to_string(lost).c_str());
  LONGS_EQUAL(0, shots[1].kernel_overflows);
}
