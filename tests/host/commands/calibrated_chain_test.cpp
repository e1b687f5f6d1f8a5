// A board and balls photographed through one bending lens nearby: strobe calibrate, then strobe digitize with
// the rig file that it wrote, then strobe reduce.
#include <fmt/format.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "sim/loading/load_scene.hpp"
#include "sim/photograph/appearance.hpp"
#include "tests/host/commands/shipped_programs.hpp"
#include "tests/support/json_lines.hpp"
#include "tests/support/pictures.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::chain;
using testing::parse_json_lines;

namespace {

constexpr const char* kScene = "zero_34";
/// Goes on in the scene's table [camera].
constexpr const char* kLens = "distance_m = 1.5\ndistortion = -0.02\n";
constexpr double kSquare_m = 0.03;
constexpr int kColumns = 21, kRows = 13;  // inner corners: the board fills the photograph

sim::Scene scene_of(const std::filesystem::path& toml) {
  const std::string text = testing::read_text(toml);
  // Only the camera matters here, and where it is: the parent leaves that as it is by default.
  auto scene = sim::parse_scene(
      "[machine]\nspeed_mps = 17\nangle_deg = -23\nspin_radps = 0\n[bounce]\ne = 0.8\nmu = 0.6\ndwell_ms = "
      "5\n" +
          text.substr(text.find('\n')),
      "camera.toml");
  if (!scene) FAIL(scene.error().message.c_str());
  return *scene;
}

/// Black squares on white paper in the plane that balls fly in, 3 x 3 rays a pixel, blurred.
cv::Mat board(const sim::Scene& scene) {
  const sim::Optics optics(scene);
  const sim::SensorSize size = optics.sensor();
  cv::Mat light(size.height, size.width, CV_32FC1);
  for (int row = 0; row < size.height; ++row) {
    for (int column = 0; column < size.width; ++column) {
      int whites = 0;
      for (int k = 0; k < 9; ++k) {
        const sim::Vec2 p = optics.plane_at(column + (k % 3 - 1) / 3.0, row + (k / 3 - 1) / 3.0);
        const double i = std::floor(p.x / kSquare_m + 0.5 * (kColumns + 1));
        const double j = std::floor(p.y / kSquare_m + 0.5 * (kRows + 1));
        const bool on = i >= 0 && j >= 0 && i <= kColumns && j <= kRows;
        whites += on && (static_cast<int>(i + j) & 1) == 0 ? 0 : 1;
      }
      light.at<float>(row, column) = 20.0F + 150.0F * static_cast<float>(whites) / 9.0F;
    }
  }
  cv::GaussianBlur(light, light, {}, 0.7);
  cv::Mat numbers;
  light.convertTo(numbers, CV_8U);
  return numbers;
}

}  // namespace

TEST_GROUP(CalibratedChain) {
  testing::TemporaryFolder folder;

  /// Of a photograph of the board; what the program printed.
  std::string calibrate(const std::string& date, int shots) {
    photograph(folder, "a", kScene, shots, kLens);
    const sim::Scene scene = scene_of(folder / "a.toml");
    strobe::testing::write_picture(folder / "board.png", board(scene));
    std::vector<std::string> surface{"--surface"};
    const sim::Optics optics(scene);
    for (const double x_m : {-0.2, 0.2}) {
      const sim::Vec2 seen = optics.image_of(optics.from_surface(x_m, 0.0, 0.0));
      surface.insert(surface.end(), {std::to_string(seen.x), std::to_string(seen.y)});
    }
    std::string rig = testing::read_text(STROBE_SHIPPED_RIG);
    testing::write_text(folder / "rig.toml", rig.erase(rig.find("#calibration"), 1));
    std::vector<std::string> words{"calibrate",
                                   folder / "board.png",
                                   "--columns",
                                   std::to_string(kColumns),
                                   "--rows",
                                   std::to_string(kRows),
                                   "--spacing-mm",
                                   "30",
                                   "--spacing-sd-percent",
                                   "0.001",
                                   "--off-plane-sd-mm",
                                   "0.05",
                                   "--lens-distance-m",
                                   "1.5",
                                   "--date",
                                   date,
                                   "--rig",
                                   folder / "rig.toml",
                                   "--json"};
    words.insert(words.end(), surface.begin(), surface.end());
    const Run run = run_program("strobe", words);
    CHECK_TEXT(run.code == 0, run.err.c_str());
    return run.out;
  }
  /// The worst error of both shots' velocities. [m/s]
  double worst_mps(const std::vector<std::string>& scale) {
    std::vector<std::string> words{"digitize", folder / "a/shot_0001.tif", folder / "a/shot_0002.tif",
                                   "--times",  folder / "a/truth.jsonl",   "--json"};
    words.insert(words.end(), scale.begin(), scale.end());
    const Run found = run_program("strobe", words);
    CHECK_TEXT(found.code == 0, found.err.c_str());
    testing::write_text(folder / "frames.jsonl", found.out);
    const auto readouts =
        parse_json_lines(run_program("strobe", {"reduce", folder / "frames.jsonl", "--json"}).out);
    const auto truths = testing::read_json_lines(folder / "a/truth.jsonl");
    LONGS_EQUAL(truths.size(), readouts.size());
    double worst = 0.0;
    for (std::size_t i = 0; i < truths.size(); ++i) {
      worst = std::max(worst, worst_velocity_mps(readouts[i], truths[i]));
      CHECK_TEXT(spins_are_right(readouts[i], truths[i]), readouts[i].dump().c_str());
    }
    return worst;
  }
};

TEST(CalibratedChain, UndoesTheLens) {
  const auto found = nlohmann::json::parse(calibrate("2026-11-21", 2));
  const auto sd = found.at("px_per_m_sd").get<double>();
  CHECK_TEXT(sd < 5e-4 * kPxPerM, std::to_string(sd).c_str());
  DOUBLES_EQUAL(kPxPerM, found.at("px_per_m").get<double>(), 4.0 * sd);
  CHECK(found.at("largest_shift_px").get<double>() > 5.0);
  const double calibrated = worst_mps({"--rig", folder / "rig.toml"});
  CHECK_TEXT(calibrated < 0.02, std::to_string(calibrated).c_str());
  const double as_it_is = worst_mps({"--px-per-m", "1500", "--px-per-m-sd", "0.15"});
  CHECK_TEXT(as_it_is > 3.0 * calibrated, std::to_string(as_it_is).c_str());
}

TEST(CalibratedChain, WarnsOfAnOldCalibration) {
  calibrate("2020-02-29", 1);
  const auto notes = [&](std::vector<std::string> more) {
    std::vector<std::string> words{
        "digitize", folder / "a/shot_0001.tif", "--rig", folder / "rig.toml", "--json", "--effort", "fast"};
    words.insert(words.end(), more.begin(), more.end());
    const Run run = run_program("strobe", words);
    CHECK_TEXT(run.code == 0, run.err.c_str());
    // The scale given on the command line goes before the rig file's.
    const auto frame = parse_json_lines(run.out).at(0);
    if (!more.empty()) DOUBLES_EQUAL(1501.0, frame.at("inputs").at("px_per_m").get<double>(), 0.0);
    return run.err;
  };
  STRCMP_CONTAINS("rig.toml: the camera's calibration is of 2020-02-29, ", notes({}).c_str());
  notes({"--px-per-m", "1501"});
}
