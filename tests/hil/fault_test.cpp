// What goes wrong on the bench ends as a flagged readout or a clear message, never as a wrong number or a
// wait without end.
#include <fmt/format.h>

#include <cstdio>
#include <string>
#include <vector>

#include "tests/hil/bench.hpp"
#include "tests/hil/truth_score.hpp"
// CppUTest redefines new; its headers come last.
#include <CppUTest/TestHarness.h>

using namespace strobe::hil;
using namespace std::chrono_literals;

namespace {

struct Shot {
  nlohmann::json readout;
  nlohmann::json truth;
};

struct Outcome {
  std::vector<Shot> shots;
  std::string messages;
  std::int64_t took_ns = 0;
  bool ended = false;
};

/// Fires shots at a bench with these faults and pairs what was read with what was true.
Outcome fire_with(const std::string& faults, int shots,
                  const std::vector<std::pair<std::string, std::string>>& rig_edits = {}) {
  BenchOptions options;
  options.scene_addition = faults;
  options.rig_edits = rig_edits;
  options.seed = 7;
  Bench bench(options);
  if (!bench.ready()) FAIL(("strobed did not come up:\n" + bench.log()).c_str());
  Outcome outcome;
  const std::int64_t start = strobe::testing::monotonic_now_ns();
  const auto fired = strobe::testing::run_to_end(bench.fire(shots, 0), 120s);
  outcome.took_ns = strobe::testing::monotonic_now_ns() - start;
  outcome.ended = fired.status.has_value();
  outcome.messages = fired.err;
  const std::vector<nlohmann::json> truths = bench.truths();
  for (auto& readout : readouts(fired.out)) {
    for (const auto& truth : truths) {
      if (truth.at("shot_id") == readout.at("shot_id")) outcome.shots.push_back({readout, truth});
    }
  }
  return outcome;
}

/// A host freeze aborted the shot: it says nothing about the fault.
bool frozen(const Shot& shot) { return has_flag(shot.readout, "shot_aborted"); }

std::string fault(const std::string& kind, int shot, const std::string& more = "") {
  return fmt::format("[[fault]]\nkind = \"{}\"\nshot = {}\n{}\n", kind, shot, more);
}

/// No number of any shot is wrong, whatever its flags; nulls are fine.
void check_no_wrong_number(const Outcome& outcome) {
  TruthScore score;
  for (const Shot& shot : outcome.shots) {
    if (shot.truth.at("ball").get<bool>())
      score.add(shot.readout, shot.truth, "shot " + shot.readout.at("shot_id").dump());
  }
  STRCMP_EQUAL("", score.beyond(4.5).c_str());
}

int count_unfrozen(const Outcome& outcome) {
  int count = 0;
  for (const Shot& shot : outcome.shots) count += frozen(shot) ? 0 : 1;
  return count;
}

void report(const char* what, const Outcome& outcome) {
  for (const Shot& shot : outcome.shots) {
    std::printf("%s: shot %s flags %s\n", what, shot.readout.at("shot_id").dump().c_str(),
                shot.readout.at("flags").dump().c_str());
  }
}

bool has_no_rebound(const nlohmann::json& readout) {
  return readout.at("vx_td_mps").is_null() && readout.at("vx_lo_mps").is_null() && readout.at("e").is_null();
}

}  // namespace

TEST_GROUP(Fault){};

TEST(Fault, ALateFlashIsFlaggedAndItsMeasuredTimeKeepsTheVelocitiesRight) {
  const std::vector<int> places{-3, -2, -1, 1, 2, 3};
  std::string faults;
  int shot = 0;
  for (const int place : places) {
    faults += fault("flash_late", ++shot,
                    fmt::format("flash_from_impact = {}\ndelay_us = 160\nlamp = \"both\"", place));
  }
  const Outcome outcome = fire_with(faults, static_cast<int>(places.size()));
  report("late flash", outcome);
  CHECK(outcome.ended);
  LONGS_EQUAL(places.size(), outcome.shots.size());
  check_no_wrong_number(outcome);
  for (const Shot& each : outcome.shots) {
    if (frozen(each)) continue;
    CHECK_TEXT(has_flag(each.readout, "late_flash"), each.readout.dump().c_str());
    CHECK_TEXT(is_spoilt(each.readout) || is_complete(each.readout), each.readout.dump().c_str());
  }
  CHECK_TEXT(count_unfrozen(outcome) >= 3, "more than half of the shots were aborted");
}

TEST(Fault, AMissingFlashIsFlaggedAndMakesNoNumberWrong) {
  std::string faults;
  int shot = 0;
  for (const int place : {-3, -2, 2, 3})
    faults += fault("flash_missing", ++shot, fmt::format("flash_from_impact = {}\nlamp = \"both\"", place));
  const Outcome outcome = fire_with(faults, 4);
  report("missing flash", outcome);
  LONGS_EQUAL(4, outcome.shots.size());
  check_no_wrong_number(outcome);
  for (const Shot& each : outcome.shots) {
    if (!frozen(each)) CHECK_TEXT(has_flag(each.readout, "missing_flash"), each.readout.dump().c_str());
  }
}

TEST(Fault, ADoubleFlashIsFlaggedAndMakesNoNumberWrong) {
  std::string faults;
  int shot = 0;
  for (const int place : {-2, 2}) {
    faults += fault("flash_double", ++shot,
                    fmt::format("flash_from_impact = {}\ndelay_us = 400\nlamp = \"both\"", place));
  }
  const Outcome outcome = fire_with(faults, 2);
  report("double flash", outcome);
  LONGS_EQUAL(2, outcome.shots.size());
  check_no_wrong_number(outcome);
  for (const Shot& each : outcome.shots) {
    if (!frozen(each)) CHECK_TEXT(has_flag(each.readout, "double_flash"), each.readout.dump().c_str());
  }
}

TEST(Fault, ABallThatMissesThePlateGivesNoNumbers) {
  const Outcome outcome = fire_with(fault("ball_misses", 1) + fault("machine_misfire", 2), 2);
  report("no ball", outcome);
  LONGS_EQUAL(2, outcome.shots.size());
  for (const Shot& each : outcome.shots) {
    CHECK_TEXT(has_no_rebound(each.readout), each.readout.dump().c_str());
    CHECK_TEXT(!each.readout.at("flags").empty(), each.readout.dump().c_str());
  }
}

TEST(Fault, APhotographThatNeverComesIsSaidWithinASecond) {
  // A second of patience in the rig file; then the readout must be there within a second more. A shot
  // takes 1.5 s at most with arming, start and end of the program are allowed another 2 s.
  const Outcome outcome =
      fire_with(fault("no_photograph", 1), 1, {{"photograph_timeout_s = 5", "photograph_timeout_s = 1"}});
  report("no photograph", outcome);
  CHECK(outcome.ended);
  LONGS_EQUAL(1, outcome.shots.size());
  CHECK(has_flag(outcome.shots[0].readout, "no_photograph"));
  CHECK(has_no_rebound(outcome.shots[0].readout));
  CHECK(outcome.took_ns < 5'500'000'000);
}

TEST(Fault, AFrameThatComesAfterAllIsStillRead) {
  const Outcome outcome = fire_with(fault("frame_late", 1, "delay_s = 2.0"), 1);
  report("late frame", outcome);
  LONGS_EQUAL(1, outcome.shots.size());
  check_no_wrong_number(outcome);
  if (!frozen(outcome.shots[0])) CHECK(is_complete(outcome.shots[0].readout));
}

TEST(Fault, ADeadSensorOrLampIsFlaggedAndMakesNoNumberWrong) {
  const Outcome outcome =
      fire_with(fault("sensor_dead", 1, "lamp = \"a\"") + fault("lamp_dead", 2, "lamp = \"b\""), 2);
  report("dead sensor, dead lamp", outcome);
  LONGS_EQUAL(2, outcome.shots.size());
  check_no_wrong_number(outcome);
  for (const Shot& each : outcome.shots) {
    if (!frozen(each)) CHECK_TEXT(has_flag(each.readout, "sensor_missing"), each.readout.dump().c_str());
  }
}

TEST(Fault, AnImageThatWasOverlookedMakesNoNumberWrong) {
  std::string faults;
  int shot = 0;
  for (const int place : {-2, -1, 1, 2})
    faults += fault("image_unseen", ++shot, fmt::format("flash_from_impact = {}", place));
  const Outcome outcome = fire_with(faults, 4);
  report("image unseen", outcome);
  LONGS_EQUAL(4, outcome.shots.size());
  check_no_wrong_number(outcome);
}
