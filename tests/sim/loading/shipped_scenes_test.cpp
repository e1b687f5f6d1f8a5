// The scenes that come with the program: each can be read and thrown, and those that stand for a rule or a
// published measurement do what it says.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <numbers>
#include <set>
#include <string>
#include <vector>

#include "sim/loading/load_scene.hpp"
#include "sim/motion/ball_path.hpp"
#include "sim/rig/truth.hpp"

#include <CppUTest/TestHarness.h>

namespace {

using namespace strobe;
using namespace strobe::sim;
using reduction::Quantity;

constexpr double kGravity_mps2 = 9.80665;
constexpr double kInch_m = 0.0254;

std::string file_of(const std::string& name) {
  return std::string(STROBE_SCENES_FOLDER).append("/").append(name).append(".toml");
}

Result<SceneText> read(const std::string& name, const std::string&) {
  std::ifstream file(file_of(name));
  if (!file) return fail("no scene " + name);
  return SceneText{std::string{std::istreambuf_iterator<char>(file), {}}, file_of(name)};
}

Scene load(const std::string& name) {
  const auto text = read(name, "");
  const auto scene = parse_scene(text->text, text->file_name, read);
  if (!scene) FAIL(scene.error().message.c_str());
  return *scene;
}

std::vector<Scene> all_scenes() {
  std::vector<Scene> scenes;
  for (const auto& entry : std::filesystem::directory_iterator(STROBE_SCENES_FOLDER))
    scenes.push_back(load(entry.path().stem().string()));
  return scenes;
}

BallPath mean_path(const Scene& scene) {
  const Scene still = without_spread(scene);
  auto path = BallPath::make(still, draw_shot_conditions(still, 1, 1));
  if (!path) FAIL(path.error().message.c_str());
  return *path;
}

double readout(const std::string& name, Quantity quantity) {
  const Scene scene = without_spread(load(name));
  return *true_readout(scene, mean_path(scene))[quantity];
}

/// Of the ball's lower side over the floor.
double rebound_inches(const std::string& name) {
  const Scene scene = load(name);
  const BallPath path = mean_path(scene);
  double highest_m = 0.0;
  for (double t = path.dwell_s(); t < 1.0; t += 1e-4) highest_m = std::max(highest_m, path.at(t).y_m);
  return (highest_m - scene.ball.radius_m()) / kInch_m;
}

}  // namespace

TEST_GROUP(ShippedScenes){};

TEST(ShippedScenes, HaveTitlesOfTheirOwn) {
  std::set<std::string> titles;
  for (const Scene& scene : all_scenes()) {
    CHECK_TEXT(scene.title != scene.name, scene.name.c_str());
    CHECK_TEXT(titles.insert(scene.title).second, scene.name.c_str());
  }
  CHECK(titles.size() >= 45);
}

TEST(ShippedScenes, CanAllBeThrown) {
  for (const Scene& scene : all_scenes()) {
    for (int shot = 1; shot <= 50; ++shot) {
      const auto path = BallPath::make(scene, draw_shot_conditions(scene, 3, shot));
      CHECK_TEXT(path.has_value(), fmt::format("{}, seed 3, shot {}", scene.name, shot).c_str());
      const impact::Motion& out = path->rebound().lift_off;
      CHECK_TEXT(std::isfinite(out.vx_mps) && out.vy_mps > 0.0 && std::isfinite(out.omega_radps),
                 scene.name.c_str());
    }
  }
}

TEST(ShippedScenes, DropFromAHundredInchesAndReboundAsTheRuleWants) {
  // The weight in contact takes g·dwell/(pi·v)·… some .1 % of e, twice that of the height; the rounding of e
  // in the file and steps of .1 ms are less.
  DOUBLES_EQUAL(53.0, rebound_inches("drop_100in_low"), 0.0025 * 53.0);
  DOUBLES_EQUAL(55.5, rebound_inches("drop_100in"), 0.0025 * 55.5);
  DOUBLES_EQUAL(58.0, rebound_inches("drop_100in_high"), 0.0025 * 58.0);
  DOUBLES_EQUAL(55.5, rebound_inches("drop_100in_airless"), 0.0025 * 55.5);
  for (const char* name : {"drop_100in_low", "drop_100in", "drop_100in_high", "drop_100in_airless"}) {
    const Scene scene = load(name);
    DOUBLES_EQUAL(-90.0, scene.machine.angle_rad * 180.0 / std::numbers::pi, 1e-12);
    CHECK(scene.ball.mass_kg > 0.0560 && scene.ball.mass_kg < 0.0594);
    // A Type 2 ball is 65.4 to 68.6 mm.
    CHECK(scene.ball.diameter_m > 0.0654 && scene.ball.diameter_m < 0.0686);
  }
}

TEST(ShippedScenes, DropStraightDownWithoutGoingAside) {
  const BallPath path = mean_path(load("drop_100in_airless"));
  for (const double t : {-0.1, -0.01, 0.001, 0.004, 0.1}) {
    DOUBLES_EQUAL(0.0, path.at(t).x_m, 1e-12);
    DOUBLES_EQUAL(0.0, path.at(t).omega_radps, 1e-9);
  }
  // A tenth of a second before it lands it is that much higher, as it must be without air.
  const double speed_mps = load("drop_100in_airless").machine.speed_mps;
  DOUBLES_EQUAL(0.0335 + 0.1 * speed_mps - 0.5 * kGravity_mps2 * 0.01, path.at(-0.1).y_m, 1e-9);
}

TEST(ShippedScenes, RateCourtsAsTheSurfaceIsGraded) {
  // The weight in contact adds .2 to .3 % to the impulse ratio and takes .1 % of e: some .1 of a point.
  DOUBLES_EQUAL(27.0, readout("itf_pace_slow", Quantity::court_pace), 0.3);
  DOUBLES_EQUAL(37.0, readout("itf_pace_medium", Quantity::court_pace), 0.3);
  DOUBLES_EQUAL(47.0, readout("itf_pace_fast", Quantity::court_pace), 0.3);
}

TEST(ShippedScenes, LetASuperballReverseItsSlip) {
  const double slip_td = 8.0 * std::cos(std::numbers::pi / 4.0);
  const double e_x = -readout("superball", Quantity::slip_lo_mps) / slip_td;
  CHECK_TEXT(e_x > 0.70 && e_x < 0.82, std::to_string(e_x).c_str());
}

TEST(ShippedScenes, ReachTheEndsOfTheScale) {
  DOUBLES_EQUAL(0.0, readout("extreme_frictionless", Quantity::mu), 1e-12);
  CHECK(readout("extreme_topspin", Quantity::vx_lo_mps) > readout("extreme_topspin", Quantity::vx_td_mps));
  CHECK(readout("extreme_backspin", Quantity::vx_lo_mps) < 0.0);
  CHECK(readout("extreme_dead", Quantity::e) < 0.05);
  CHECK(std::abs(readout("extreme_steepest", Quantity::theta_in_deg)) > 89.0);
  CHECK(load("extreme_pixels").camera.pixels);
}

TEST(ShippedScenes, TiltTheirAxesAndLeaveThePlaneAsTheirNamesSay) {
  const auto spatial = [](const std::string& name) {
    return true_spatial(mean_path(without_spread(load(name))));
  };
  using enum reduction::SpatialQuantity;
  DOUBLES_EQUAL(10.0, spatial("axis_tilted_10")[spin_axis_tilt_td_deg]->value, 0.01);
  DOUBLES_EQUAL(45.0, spatial("axis_tilted_45")[spin_axis_tilt_td_deg]->value, 0.01);
  DOUBLES_EQUAL(200.0, spatial("sidespin_23")[omega_y_td_radps]->value, 1e-9);
  const BallPath aside = mean_path(load("off_plane_2deg"));
  DOUBLES_EQUAL(2.0, std::atan2(aside.at(0.0).vz_mps, aside.at(0.0).vx_mps) * 180.0 / std::numbers::pi, 1e-9);
}
