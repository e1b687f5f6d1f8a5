// Photographs that come by the wire: the shipped programs with the shipped library of GenICam and a simulated camera that
// loses packets and frames, whose clock is another one, and that vanishes and comes back.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "tests/hil/rig_fixture.hpp"
#include "tests/hil/truth_score.hpp"
#include "tests/support/string_from.hpp"

#include "tests/hil/expectations.hpp"

using namespace strobe::hil;

namespace {

constexpr int kAway_s = 8;

/// Shots of the series; $STROBE_CAMERA_SHOTS for more of them.
int shots_to_fire() {
  const char* const shots = std::getenv("STROBE_CAMERA_SHOTS");
  return shots == nullptr ? 10 : std::max(10, std::atoi(shots));
}

std::string fault(const std::string& kind, int shot, const std::string& more = "") {
  return fmt::format("[[fault]]\nkind = \"{}\"\nshot = {}\n{}\n", kind, shot, more);
}

/// A link that loses, a clock that is another one, and of every shots_to_fire() a few that go wrong by name. What a
/// photograph takes is known here, so a shot without one is soon over: a camera that is away for longer must hold the
/// series up by itself.
RigFixtureOptions rig_with_camera(int shots) {
  RigFixtureOptions options;
  options.rig_edits = kShortExposure;
  options.scene_addition =
      "[camera]\npx_per_m = 1500\norigin_x_px = 600\norigin_y_px = 150\n"
      "[camera_link]\nloss = 0.01\nclock_offset_s = 1234.5\nclock_drift_ppm = 50\n" +
      std::string(shots > 100 ? "drop = 0.02\n" : "") + fault("frame_dropped", 2) + fault("frame_twice", 4) +
      fault("frame_incomplete", 6) + fault("camera_vanishes", 8, fmt::format("delay_s = {}", kAway_s)) +
      fault("frame_late", 10, "delay_s = 4");
  if (shots > 100) options.scene_addition += fault("camera_vanishes", shots / 2, "delay_s = 3");
  options.rig_edits.emplace_back("photograph_timeout_s = 5", "photograph_timeout_s = 2");
  options.rig_edits.emplace_back("\npx_per_m = 4000.0", "\npx_per_m = 1500\npx_per_m_sd = 0.5");
  options.rig_edits.emplace_back("[camera]\n", "[camera]\nkind = \"genicam\"\naddress = \"127.0.1.7\"\n");
  options.sim_options = {"--camera", "gev", "--camera-address", "127.0.1.7", "--time", "fast"};
  return options;
}

/// Distance in the stated sds over numbers that differ from shot to shot by many of them.
double distance(const nlohmann::json& readout, const nlohmann::json& truth) {
  double sum = 0.0;
  for (const char* quantity : {"e", "theta_out_deg", "vx_td_mps", "omega_lo_radps"}) {
    const double sd = readout.at("sd").at(quantity).get<double>();
    sum += std::pow((readout.at(quantity).get<double>() - truth.at("readout").at(quantity).get<double>()) / sd, 2);
  }
  return std::sqrt(sum);
}

/// An own truth is nearer: the square is a sum of four squares of errors, beyond 64 once in 10^12. flags tell of shots
/// whose sds do not hold.
constexpr double kOwn = 8.0;

/// Share of shots that fit another's truth, too.
double share_taken_for_others(const std::vector<nlohmann::json>& good, const std::vector<nlohmann::json>& truths) {
  int pairs = 0, fitting = 0;
  for (const nlohmann::json& readout : good) {
    for (const nlohmann::json& truth : truths) {
      if (truth.at("shot_id") == readout.at("shot_id")) continue;
      ++pairs;
      fitting += distance(readout, truth) < kOwn ? 1 : 0;
    }
  }
  return static_cast<double>(fitting) / pairs;
}

const nlohmann::json& truth_of_shot(const std::vector<nlohmann::json>& truths, const nlohmann::json& shot_id) {
  return *std::ranges::find(truths, shot_id, [](const nlohmann::json& truth) { return truth.at("shot_id"); });
}

int count(const std::string& text, const std::string& words) {
  int found = 0;
  for (std::size_t at = text.find(words); at != std::string::npos; at = text.find(words, at + 1)) ++found;
  return found;
}

}  // namespace

TEST_GROUP(NetworkCamera){};

TEST(NetworkCamera, EachPhotographIsOfItsOwnShotOrOfNoneAndEveryLossIsTold) {
  const int shots = shots_to_fire();
  ReadyRig rig(rig_with_camera(shots));
  const auto fired = strobe::testing::run_process(rig.fire(shots, shots), std::chrono::hours{2});
  CHECK_TEXT(fired.status == strobe::testing::ExitStatus({0, 0}), fired.err.c_str());
  const std::vector<nlohmann::json> truths = rig.truths();
  std::vector<nlohmann::json> good;
  int lost = 0;
  for (const nlohmann::json& readout : readouts(fired.out)) {
    if (has_flag(readout, "no_photograph")) ++lost;
    if (!is_rejected(readout)) good.push_back(readout);
  }
  LONGS_EQUAL(shots, good.size());
  for (const nlohmann::json& readout : good) {
    if (!readout.at("flags").empty()) continue;
    CHECK_TEXT(distance(readout, truth_of_shot(truths, readout.at("shot_id"))) < kOwn, readout.dump().c_str());
  }
  // Another shot's picture would be noticed.
  CHECK_TRUE(share_taken_for_others(good, truths) < 0.02);
  // Dropped, incomplete, of the camera that went away, and late: each is missed, and its loss or its lateness told.
  CHECK_TRUE(lost >= 4);
  CHECK_TRUE(count(fired.err, "a photograph is lost, the camera's frame ") >= 1);
  STRCMP_CONTAINS("photograph of shot 6: lost: ", fired.err.c_str());
  STRCMP_CONTAINS("a second one of shot 4: not used", fired.err.c_str());
  STRCMP_CONTAINS("the camera is gone: ", fired.err.c_str());
  STRCMP_CONTAINS("is back", fired.err.c_str());
  STRCMP_CONTAINS("were lost and sent again", fired.err.c_str());
}

TEST(NetworkCamera, NoBallIsThrownWhileItIsAway) {
  ReadyRig rig(rig_with_camera(10));
  ran(rig.fire(9, 9));
  std::int64_t gone_ns = 0;
  for (const nlohmann::json& truth : rig.truths()) {
    if (truth.at("shot").get<int>() == 8) gone_ns = truth.at("closed_ns").get<std::int64_t>();
  }
  const LineChanges changes = rig.finish();
  CHECK_TRUE(gone_ns > 0 && changes.rises("TRIGGER") >= 9);
  LONGS_EQUAL(0, changes.rises("TRIGGER", gone_ns, gone_ns + kAway_s * 1000 * kMs));
}
