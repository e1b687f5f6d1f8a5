// Photographs of one flight without a surface, rendered, digitized and reduced by the shipped programs.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "sim/loading/load_scene.hpp"
#include "sim/shoot/shoot.hpp"
#include "tests/host/commands/shipped_programs.hpp"
#include "tests/support/json_lines.hpp"
#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::chain;
using nlohmann::json;
using testing::parse_json_lines;
using testing::write_text;

namespace {

constexpr int kShots = 2;
constexpr int kSeed = 3;
constexpr std::array kNames{"speed_mps", "angle_deg", "vx_mps", "vy_mps", "omega_radps"};

struct Flights {
  std::vector<json> truth, frames, readouts;
  sim::Scene scene;
};

/// Shots of a condition as the camera of photo_throw or photo_stroke shows them.
Flights flights(const testing::TemporaryFolder& folder, const std::string& view, const std::string& condition) {
  const auto camera = sim::load_scene(view);
  const auto thrown = sim::load_scene(condition);
  CHECK_TRUE(camera && thrown);
  const int width_px = camera->photograph.width_px;
  const std::string name = view + "_" + condition, file = folder / (name + ".toml");
  write_text(file, fmt::format("inherits = \"{}\"\n[background]\nplate = false\n[camera]\norigin_x_px = {}\n"
                               "half_width_m = {}\n{}",
                               condition, camera->camera.origin_x_px, camera->camera.half_width_m,
                               width_px > 0 ? fmt::format("[photograph]\nwidth_px = {}\n", width_px) : ""));
  const Run made = run_program("strobe-sim", {"photograph", "--scene", file, "--seed", std::to_string(kSeed),
                                              "--shots", std::to_string(kShots), "--out", folder / name, "--json"});
  CHECK_TEXT(made.code == 0, made.err.c_str());
  std::vector<std::string> words{"digitize"};
  for (int shot = 1; shot <= kShots; ++shot)
    words.push_back(folder / fmt::format("{}/shot_{:04}.tif", name, shot));
  words.insert(words.end(), {"--ball-diameter-m", "0.0651", "--times", folder / (name + "/truth.jsonl"), "--json"});
  const Run found = run_program("strobe", words);
  CHECK_TEXT(found.code == 0, found.err.c_str());
  write_text(folder / (name + ".jsonl"), found.out);
  const Run reduced = run_program("strobe", {"reduce", folder / (name + ".jsonl"), "--json"});
  CHECK_TEXT(reduced.code == 0, reduced.err.c_str());
  auto scene = sim::load_scene(file);
  CHECK_TRUE(scene.has_value());
  return {parse_json_lines(made.out), parse_json_lines(found.out), parse_json_lines(reduced.out), std::move(*scene)};
}

double apart_px(const json& a, const json& b) {
  return std::hypot(a.at("centre_px")[0].get<double>() - b.at("centre_px")[0].get<double>(),
                    a.at("centre_px")[1].get<double>() - b.at("centre_px")[1].get<double>());
}

/// After the first pulse's edge, of the image that the launch is of. An even train does not tell which of its flashes
/// it was: its place does.
double launched_s(const Flights& flights, std::size_t i) {
  const json& images = flights.frames.at(i).at("images");
  const auto first = std::ranges::find_if(images, [&](const json& image) {
    return image.at("time_s") == flights.readouts.at(i).at("launch").at("time_s");
  });
  CHECK_TRUE(first != images.end());
  const json& truths = flights.truth.at(i).at("images");
  const auto truth = std::ranges::min_element(
      truths, {}, [&](const json& image) { return apart_px(image, *first); });
  CHECK_TRUE(apart_px(*truth, *first) < 5.0);
  return truth->at("time_s");
}

/// In the order of kNames, at the launch's own image, in the photograph's axes.
std::array<double, kNames.size()> true_launch(const Flights& flights, std::size_t i) {
  const auto shot = sim::shoot(flights.scene, kSeed, static_cast<int>(i) + 1);
  CHECK_TRUE(shot && shot->exposure.ball);
  const json& truth = flights.truth.at(i);
  // The program's shot is this one.
  LONGS_EQUAL(truth.at("touchdown_ns").get<std::int64_t>(), shot->exposure.ball->touchdown.time_since_epoch().count());
  const double time_s =
      launched_s(flights, i) + to_seconds(shot->exposure.pulses.front().edge - shot->exposure.ball->touchdown);
  const sim::BallState state = shot->exposure.ball->path.at(time_s);
  const double roll = flights.scene.camera.roll_rad;
  const double vx = std::cos(roll) * state.vx_mps - std::sin(roll) * state.vy_mps;
  const double vy = std::sin(roll) * state.vx_mps + std::cos(roll) * state.vy_mps;
  return {std::hypot(vx, vy), std::atan2(vy, vx) * 180.0 / std::numbers::pi, vx, vy, state.omega_radps};
}

}  // namespace

TEST_GROUP(LaunchChain) { testing::TemporaryFolder folder; };

TEST(LaunchChain, MeasuresThrowsAndStrokesWithinTheirSdsAndInventsNothing) {
  std::array<double, kNames.size()> sum{};
  int count = 0;
  for (const char* view : {"photo_throw", "photo_stroke"}) {
    for (const char* condition : {"zero_17", "zero_34", "top_34", "back_35", "back_40"}) {
      const Flights seen = flights(folder, view, condition);
      LONGS_EQUAL(kShots, seen.readouts.size());
      for (std::size_t i = 0; i < seen.readouts.size(); ++i) {
        const json& readout = seen.readouts[i];
        for (const char* name : {"theta_in_deg", "v_td_mps", "omega_td_radps", "v_lo_mps", "e", "mu", "dwell_time_ms",
                                 "regime"})
          CHECK_TEXT(readout.at(name).is_null(), name);
        CHECK_TEXT(readout.contains("launch"), readout.dump().c_str());
        const json& launch = readout.at("launch");
        const auto truth = true_launch(seen, i);
        ++count;
        for (std::size_t k = 0; k < kNames.size(); ++k) {
          const double z = (launch.at(kNames[k]).get<double>() - truth[k]) / launch.at("sd").at(kNames[k]).get<double>();
          // Beyond 5 sd is none of a hundred numbers, were their sds right to a fifth.
          CHECK_TEXT(std::abs(z) < 5.0, fmt::format("{} {} {}: {}", view, condition, kNames[k], launch.dump()).c_str());
          sum[k] += z * z;
        }
      }
    }
  }
  const auto rms = [&](std::size_t k) { return std::sqrt(sum[k] / count); };
  for (std::size_t k = 0; k < kNames.size(); ++k) std::printf("%s %.2f ", kNames[k], rms(k));
  for (std::size_t k = 0; k < kNames.size(); ++k) {
    // Of twenty the rms is known to 16 %. Without a calibration speeds follow the diameters, in which the images of a
    // photograph share an error of some .02 % that no residual shows: as much again as a speed's own sd.
    const bool by_diameter = k != 1 && k != 4;
    CHECK_TEXT(rms(k) > 0.5 && rms(k) < (by_diameter ? 2.5 : 1.5), kNames[k]);
  }
}
