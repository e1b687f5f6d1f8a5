// `strobe calibrate` from a photograph to the calibration file, and what is read from that.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>

#include "host/commands/command.hpp"
#include "host/config/rig_file.hpp"
#include "host/photographs/measure_photograph.hpp"
#include "tests/host/camera/pinhole.hpp"
#include "tests/support/pictures.hpp"
#include "tests/support/temporary_folder.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using host::CameraTable;

namespace {

CameraTable measured() {
  CameraTable table;
  table.calibrated = "2026-11-21";
  table.board = "chessboard";
  table.photographs = 2;
  table.residual_px = 0.1;
  table.tilt_deg = 1.0 / 3.0;
  table.width_px = 640;
  table.height_px = 480;
  table.px_per_m = 1000.0 / 3.0;
  table.px_per_m_sd = 0.1;
  table.map = host::CameraMap{{319.5, 239.5}, 800.0, {0.1, 0, 0, 0}, {1, 0, 0, 0, -1, 479, 0, 0, 1}};
  table.map_errors = {{{1e-3, 0, 1, 0, 0, 0, 1e-7, 0, 0}, {1.0 / 3.0, 0, 0, 1e-4}}, {}};
  table.viewpoint_px = {300, 200, 1e4};
  table.viewpoint_sd_px = 7.0;
  return table;
}

const camera::BoardPattern kPattern{camera::BoardKind::chessboard, 7, 5, 0.02};
const testing::Pinhole kPinhole{400, 300, 1600.0, -0.2, 0.0, {199.5, 149.5}};

const char* const kRig = "rig = \"b\"\n[camera]\npx_per_m = 7\ncalibration = \"camera.toml\"\n";

}  // namespace

TEST_GROUP(Calibration){};

TEST(Calibration, ReadsBackToTheLastBitAndStandsForTheRigFilesOwn) {
  CameraTable camera;
  camera.folder = "in";
  camera.max_age_days = 10.0;
  camera.surface_px = {0, 0, 9, 0};  // it was one of the old map
  const auto read = host::with_calibration(camera, host::calibration_text(measured()), "camera.toml");
  CHECK_TRUE_TEXT(read.has_value(), read ? "" : read.error().message.c_str());
  STRCMP_EQUAL(host::calibration_text(measured()).c_str(), host::calibration_text(*read).c_str());
  DOUBLES_EQUAL(1000.0 / 3.0, *read->px_per_m, 0);
  DOUBLES_EQUAL(479, read->map->rectify[5], 0);
  DOUBLES_EQUAL(1e-7, read->map_errors.at(0).rectify[6], 0);
  CHECK_FALSE(read->surface_px.has_value());
  STRCMP_EQUAL("in", read->folder->c_str());
  DOUBLES_EQUAL(10, read->max_age_days, 0);
}

TEST(Calibration, NamesTheFileInWhatIsWrong) {
  STRCMP_EQUAL("camera.toml:2: px_per_metre: unknown key",
               host::with_calibration({}, "\npx_per_metre = 3\n", "camera.toml").error().message.c_str());
  STRCMP_EQUAL("camera.toml:1: map_errors: needs rectify too",
               host::with_calibration({}, "map_errors = [1]\n", "camera.toml").error().message.c_str());
  std::string text = host::calibration_text(measured());
  text.insert(text.find("map_errors = [") + 14, "7, ");
  STRCMP_CONTAINS("map_errors: must be 13 numbers for each error, of at most 64",
                  host::with_calibration({}, text, "camera.toml").error().message.c_str());
  for (const char* name : {"../camera.toml", "rig.toml", "camera"}) {
    const std::string rig = fmt::format("rig = \"b\"\n[camera]\ncalibration = \"{}\"\n", name);
    STRCMP_CONTAINS("rig.toml:3: camera.calibration: must be the name of a file beside this one",
                    host::read_rig(rig, "rig.toml").error().message.c_str());
  }
}

TEST_GROUP(CalibrateCommand) {
  testing::TemporaryFolder folder;
  std::mt19937_64 random{3};

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

  void write(const std::string& name, const std::string& text) { testing::write_text(folder / name, text); }

  /// The board of kPattern a metre away, turned so.
  void photograph_board(const std::string& name, cv::Vec3d turns_rad) {
    cv::Mat numbers;
    testing::photograph(kPinhole, testing::pose(kPattern, 1.0, turns_rad), kPattern, 0.005, random)
        .convertTo(numbers, CV_16U, 65535.0);
    strobe::testing::write_picture(in(name), numbers);
  }

  /// The calibration file, if `images` give one.
  std::string calibrated(const std::vector<std::string>& images, int exit_status = host::kDone) {
    std::filesystem::remove(folder / "camera.toml");
    std::vector<std::string> arguments;
    for (const std::string& image : images) arguments.push_back(in(image));
    arguments.insert(arguments.end(),
                     {"--rig", in("rig.toml"), "--columns", "7", "--rows", "5", "--spacing-mm", "20", "--date",
                      "2026-11-20", "--tolerance-percent", "1"});
    LONGS_EQUAL(exit_status, run(arguments));
    const bool written = std::filesystem::exists(folder / "camera.toml");
    CHECK_EQUAL(exit_status == host::kDone, written);
    return written ? testing::read_text(folder / "camera.toml") : "";
  }
};

TEST(CalibrateCommand, FromAPhotographToTheDigitizersMap) {
  const cv::Vec3d turns_rad{0.02, 0.03, 0.01};
  const testing::Pose pose = testing::pose(kPattern, 1.0, turns_rad);
  photograph_board("plane.png", turns_rad);
  write("rig.toml", kRig);
  std::vector<std::string> arguments{
      in("plane.png"), "--rig",     in("rig.toml"), "--columns", "7",
      "--rows",        "5",         "--spacing-mm", "20",        "--lens-distance-m",
      "1.0",           "--surface", "10",           "250",       "390",
      "250",           "--date",    "2026-11-20",   "--json"};
  LONGS_EQUAL(host::kFailed, run(arguments));  // over 20 % of a small photograph
  CHECK_FALSE(std::filesystem::exists(folder / "camera.toml"));
  arguments.insert(arguments.end(), {"--tolerance-percent", "1"});
  LONGS_EQUAL(host::kDone, run(arguments));
  CHECK_FALSE(host::load_rig(in("rig.toml"))->camera.map_errors.empty());
  const auto rig = host::load_rig(in("rig.toml"));
  CHECK_TRUE_TEXT(rig.has_value(), rig ? "" : rig.error().message.c_str());
  STRCMP_EQUAL("2026-11-20", rig->camera.calibrated->c_str());
  STRCMP_EQUAL(testing::read_text(folder / "camera.toml").c_str(), rig->calibration_text.c_str());
  STRCMP_EQUAL(kRig, testing::read_text(folder / "rig.toml").c_str());
  const auto settings = host::digitize_settings(*rig, 400, 300);
  CHECK_TRUE(settings->map.viewpoint().has_value() && settings->surface.has_value());
  const cv::Point2d a = settings->map.to_plane(kPinhole.project(pose.to_camera({0.0, 0.0})));
  const cv::Point2d b = settings->map.to_plane(kPinhole.project(pose.to_camera({0.12, 0.08})));
  // 35 corners, each some hundredths of a pixel off over 230 px; the board's print and place are exact here.
  DOUBLES_EQUAL(std::hypot(0.12, 0.08), cv::norm(b - a) / *settings->px_per_m, 5e-4 * 0.144);
}

TEST(CalibrateCommand, LeavesOutPhotographsThatShowNoBoardAndSaysWhich) {
  write("rig.toml", kRig);
  photograph_board("plane.png", {0.0, 0.0, 0.01});
  photograph_board("left.png", {0.0, 0.4, 0.0});
  photograph_board("down.png", {0.4, 0.0, 0.0});
  strobe::testing::write_picture(in("\"hand\".png"), cv::Mat(300, 400, CV_8UC1, cv::Scalar(90)));
  strobe::testing::write_picture(in("small.png"), cv::Mat(120, 160, CV_8UC1, cv::Scalar(90)));
  write("text.png", "no picture");

  const std::string good = calibrated({"plane.png", "left.png", "down.png"});
  const std::string found =
      calibrated({"plane.png", "\"hand\".png", "left.png", "small.png", "down.png", "text.png", "none.png"});
  const auto rig = host::load_rig(in("rig.toml"));
  CHECK_TRUE_TEXT(rig.has_value(), rig ? "" : rig.error().message.c_str());
  LONGS_EQUAL(3, *rig->camera.photographs);
  const std::string left_out = *rig->camera.left_out;
  for (const char* const why :
       {"\"hand\".png: no chessboard 7 x 5, 20 mm is seen as a whole; ",
        "small.png: 160 x 120 pixels, but the first photograph has 400 x 300; ",
        "text.png: not a TIFF, PNG or JPEG file; ", "none.png: no such file"})
    STRCMP_CONTAINS(why, left_out.c_str());
  // All else is what the three that show the board give without them.
  const std::size_t line = found.find("left_out = "), end = found.find('\n', line) + 1;
  CHECK_EQUAL(good, found.substr(0, line) + found.substr(end));
}

TEST(CalibrateCommand, RefusesWithoutTheBoardInThePlaneAndWithNoneOfTheSlantedOnes) {
  write("rig.toml", kRig);
  photograph_board("plane.png", {0.0, 0.0, 0.01});
  photograph_board("left.png", {0.0, 0.4, 0.0});
  strobe::testing::write_picture(in("hand.png"), cv::Mat(300, 400, CV_8UC1, cv::Scalar(90)));
  calibrated({"hand.png", "plane.png", "left.png"}, host::kBadInput);
  calibrated({"plane.png", "hand.png", "hand.png"}, host::kBadInput);
  CHECK(!calibrated({"plane.png", "hand.png", "left.png"}).empty());
}

TEST(CalibrateCommand, SaysWhatIsWrongAndLeavesTheCalibrationAlone) {
  write("rig.toml", kRig);
  STRCMP_CONTAINS("rig.toml: camera.calibration: ", host::load_rig(in("rig.toml")).error().message.c_str());
  STRCMP_CONTAINS("camera.toml: No such file", host::load_rig(in("rig.toml")).error().message.c_str());
  write("camera.toml", "px_per_m = 5\n");
  write("unnamed.toml", "rig = \"b\"\n");
  write("text.png", "no picture");
  strobe::testing::write_picture(in("empty.png"), cv::Mat(120, 160, CV_8UC1, cv::Scalar(90)));
  for (const char* image : {"text.png", "empty.png", "absent.png"})
    LONGS_EQUAL(host::kBadInput, run({in(image), "--rig", in("rig.toml"), "--spacing-mm", "20"}));
  for (const char* rig : {"none.toml", "unnamed.toml"}) {
    LONGS_EQUAL(host::kBadInput, run({in("empty.png"), "--rig", in(rig), "--spacing-mm", "20"}));
  }
  LONGS_EQUAL(host::kBadInput, run({in("empty.png"), "--date", "today", "--spacing-mm", "20"}));
  DOUBLES_EQUAL(5, *host::load_rig(in("rig.toml"))->camera.px_per_m, 0);
}

TEST(CalibrateCommand, AdvisesWhereTheNextPhotographsGoAlsoWhereItRefuses) {
  photograph_board("plane.png", {0.02, 0.03, 0.01});
  const std::vector<std::string> arguments{in("plane.png"), "--columns",       "7",           "--rows",
                                           "5",             "--spacing-mm",    "20",          "--advise",
                                           "2",             "--advise-figure", in("next.svg")};
  LONGS_EQUAL(host::kFailed, run(arguments));  // 0.2 % is not reached by one photograph
  STRCMP_CONTAINS(" side nearer, ", testing::read_text(folder / "next.svg").c_str());
  std::vector<std::string> wrong = arguments;
  wrong.back() = in("none/next.svg");
  LONGS_EQUAL(host::kBadInput, run(wrong));
}
