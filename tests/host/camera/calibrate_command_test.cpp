#include <unistd.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "host/commands/command.hpp"
#include "host/config/camera_writer.hpp"
#include "host/photographs/digitize_settings.hpp"
#include "tests/host/camera/pinhole.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using host::CameraTable;
using host::with_calibration;

namespace {

CameraTable measured() {
  CameraTable table;
  table.calibrated = "2026-11-21";
  table.board = "a \"board\"";
  table.photographs = 2;
  table.width_px = 640;
  table.height_px = 480;
  table.px_per_m = 1000.0 / 3.0;
  table.px_per_m_sd = 0.1;
  table.map = host::CameraMap{{319.5, 239.5}, 800.0, {0.1, 0, 0, 0}, {1, 0, 0, 0, -1, 479, 0, 0, 1}};
  table.viewpoint_px = {300, 200, 1e4};
  return table;
}

std::string contents(const std::filesystem::path& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

}  // namespace

TEST_GROUP(CameraWriter){};

TEST(CameraWriter, AddsATableBehindTheFilesBytes) {
  const std::string rig = "# mine\nrig = \"b\"   # name\n[record]\noperator = \"[camera]\"";
  const auto text = with_calibration(rig, "rig.toml", measured());
  CHECK_TRUE_TEXT(text.has_value(), text ? "" : text.error().message.c_str());
  CHECK_TRUE(text->starts_with(rig + "\n\n[camera]\n"));
  const auto camera = host::read_rig(*text, "rig.toml")->camera;
  DOUBLES_EQUAL(1000.0 / 3.0, *camera.px_per_m, 0);  // to the last bit
  STRCMP_EQUAL("a \"board\"", camera.board->c_str());
}

TEST(CameraWriter, ReplacesWhatWasMeasuredAndNothingElse) {
  const std::string before = "rig = \"b\"\n[camera]   # the bench's\nfolder = \"in\"   # tethered\n";
  const std::string old =
      "px_per_m = 5\nrectify = [1, 0, 0,  # over lines\n  0, 1, 0,\n 0, 0, 1]\nlens_focal_px = 9\n"
      "lens_centre_px = [0, 0]\nlens_distortion = [0, 0, 0, 0]\nwidth_px = 99\nheight_px = 99\n"
      "surface_px = [0, 0, 9, 0]\n";
  const std::string after = "max_age_days = 10\n\n# next\n[ball]\ndiameter_m = 0.066\n";
  const auto text = with_calibration(before + old + after, "rig.toml", measured());
  CHECK_TRUE_TEXT(text.has_value(), text ? "" : text.error().message.c_str());
  CHECK_TRUE(text->starts_with(before + "max_age_days = 10\n"));
  CHECK_TRUE(text->ends_with("\n[ball]\ndiameter_m = 0.066\n"));
  const auto rig = host::read_rig(*text, "rig.toml");
  STRCMP_EQUAL("in", rig->camera.folder->c_str());
  LONGS_EQUAL(640, *rig->camera.width_px);
  CHECK_FALSE(rig->camera.surface_px.has_value());  // it was one of the old map
}

TEST(CameraWriter, WritingTwiceIsWritingOnce) {
  const auto once = with_calibration("rig = \"b\"\r\n[ball]\r\nmass_kg = 0.06\r\n", "rig.toml", measured());
  CHECK_EQUAL(*once, *with_calibration(*once, "rig.toml", measured()));
  CHECK_TRUE(once->find("px_per_m_sd = 0.1\r\n") != std::string::npos);
}

TEST(CameraWriter, RefusesATableWrittenOtherwise) {
  for (const char* rig :
       {"rig = \"b\"\ncamera = { folder = \"in\" }\n", "rig = \"b\"\ncamera.folder = \"in\"\n"}) {
    const auto text = with_calibration(rig, "rig.toml", measured());
    CHECK_FALSE(text.has_value());
    STRCMP_CONTAINS("rig.toml:2: camera: write the table as [camera]", text.error().message.c_str());
  }
}

TEST_GROUP(CalibrateCommand) {
  std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("strobe-calibrate-" + std::to_string(::getpid()));

  void setup() override { std::filesystem::create_directories(folder); }
  void teardown() override { std::filesystem::remove_all(folder); }

  int run(std::vector<std::string> arguments) {
    CLI::App app;
    int exit_status = -1;
    host::add_calibrate_command(app, exit_status);
    std::reverse(arguments.begin(), arguments.end());
    arguments.push_back("calibrate");
    app.parse(arguments);
    return exit_status;
  }

  std::string in(const std::string& name) const { return (folder / name).string(); }

  void write(const std::string& name, const std::string& text) { std::ofstream(folder / name) << text; }
};

TEST(CalibrateCommand, FromAPhotographToTheDigitizersMap) {
  const camera::BoardPattern pattern{camera::BoardKind::chessboard, 7, 5, 0.02};
  const testing::Pinhole pinhole{400, 300, 1600.0, -0.2, 0.0, {199.5, 149.5}};
  const testing::Pose pose = testing::pose(pattern, 1.0, {0.02, 0.03, 0.01});
  std::mt19937_64 random(3);
  cv::Mat bytes;
  testing::photograph(pinhole, pose, pattern, 0.005, random).convertTo(bytes, CV_16U, 65535.0);
  cv::imwrite(in("plane.png"), bytes);
  write("rig.toml", "rig = \"b\"\n");
  LONGS_EQUAL(host::kDone, run({in("plane.png"), "--rig", in("rig.toml"), "--columns", "7", "--rows", "5",
                                "--spacing-mm", "20", "--lens-distance-m", "1.0", "--surface", "10", "250",
                                "390", "250", "--date", "2026-11-20", "--json"}));
  const auto rig = host::load_rig(in("rig.toml"));
  CHECK_TRUE_TEXT(rig.has_value(), rig ? "" : rig.error().message.c_str());
  STRCMP_EQUAL("2026-11-20", rig->camera.calibrated->c_str());
  const auto settings = host::digitize_settings(*rig, 400, 300);
  CHECK_TRUE(settings->map.viewpoint().has_value() && settings->surface.has_value());
  const cv::Point2d a = settings->map.to_plane(pinhole.project(pose.to_camera({0.0, 0.0})));
  const cv::Point2d b = settings->map.to_plane(pinhole.project(pose.to_camera({0.12, 0.08})));
  // 35 corners, each some hundredths of a pixel off over 230 px; the board's print and place are exact here.
  DOUBLES_EQUAL(std::hypot(0.12, 0.08), cv::norm(b - a) / settings->px_per_m, 5e-4 * 0.144);
}

TEST(CalibrateCommand, SaysWhatIsWrongAndLeavesTheRigFileAlone) {
  write("rig.toml", "rig = \"b\"\n");
  write("text.png", "no picture");
  cv::imwrite(in("empty.png"), cv::Mat(120, 160, CV_8UC1, cv::Scalar(90)));
  for (const char* image : {"text.png", "empty.png", "absent.png"})
    LONGS_EQUAL(host::kBadInput, run({in(image), "--rig", in("rig.toml"), "--spacing-mm", "20"}));
  LONGS_EQUAL(host::kBadInput, run({in("empty.png"), "--rig", in("none.toml"), "--spacing-mm", "20"}));
  LONGS_EQUAL(host::kBadInput, run({in("empty.png"), "--date", "today", "--spacing-mm", "20"}));
  CHECK_EQUAL("rig = \"b\"\n", contents(folder / "rig.toml"));
}
