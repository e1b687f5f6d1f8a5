// The rig file of each scene that comes with the program: read by strobed's reader and the host's, and held against the
// scene.
#include "sim/rig_file/rig_file.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "firmware/core/rig.hpp"
#include "host/config/rig_file.hpp"
#include "host/photographs/measure_photograph.hpp"
#include "sim/loading/load_scene.hpp"
#include "sim/photograph/appearance.hpp"
#include "tests/support/temporary_folder.hpp"

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe;
using strobe::sim::RigFileSettings;
using strobe::sim::Scene;
namespace fs = std::filesystem;

std::vector<Scene> scenes() {
  std::vector<Scene> all;
  for (const auto& file : fs::directory_iterator(STROBE_SCENES_FOLDER)) {
    const auto scene = sim::load_scene(file.path().string());
    CHECK_TEXT(scene.has_value(), file.path().c_str());
    all.push_back(*scene);
  }
  CHECK(all.size() > 50);
  return all;
}

host::RigFile host_rig(const Scene& scene, const RigFileSettings& settings = {}) {
  const auto rig = host::read_rig(sim::rig_file_text(scene, settings), scene.name);
  CHECK_TEXT(rig.has_value(), rig ? "" : rig.error().message.c_str());
  return *rig;
}

RigFileSettings photographs_in(const fs::path& folder) {
  RigFileSettings settings;
  settings.photographs = folder;
  return settings;
}

}  // namespace

TEST_GROUP(RigFileOfAScene){};

TEST(RigFileOfAScene, IsTakenByStrobedAndFitsLampsShutterAndMachine) {
  for (const Scene& scene : scenes()) {
    const auto rig = firmware::read_rig(sim::rig_file_text(scene, {}), scene.name);
    CHECK_TEXT(rig.has_value(), rig ? "" : rig.error().message.c_str());
    CHECK_TEXT(to_seconds(rig->lamps.min_period) > scene.lamps.recharge_s, scene.name.c_str());
    CHECK_TEXT(rig->plan.period >= rig->lamps.min_period, scene.name.c_str());
    DOUBLES_EQUAL(scene.lamps.delay_s * 1e6, rig->lamps.delay_a_us, 1e-5);  // written to a part in a million
    DOUBLES_EQUAL(scene.shutter.open_lag_s, to_seconds(rig->shutter.lag), 1e-9);
    DOUBLES_EQUAL(scene.machine.lag_s, to_seconds(rig->machine.lag), 1e-6 * scene.machine.lag_s);  // likewise
    CHECK_TEXT(rig->chip == scene.chip.name, rig->chip.c_str());
  }
}

TEST(RigFileOfAScene, TellsTheHostOfItsBallAndItsCamera) {
  for (const Scene& scene : scenes()) {
    const host::RigFile rig = host_rig(scene);
    DOUBLES_EQUAL(scene.ball.diameter_m, rig.ball.diameter_m, 1e-8);
    DOUBLES_EQUAL(scene.ball.alpha, *rig.ball.alpha, 1e-6);
    DOUBLES_EQUAL(scene.camera.px_per_m, *rig.camera.px_per_m, 1e-2);
    CHECK_TEXT(*rig.camera.px_per_m_sd > 0.0, scene.name.c_str());
    CHECK_FALSE(host::calibration_warning(rig.camera, WallTime{}).has_value());
  }
}

TEST(RigFileOfAScene, MapsThePhotographToThePlaneOfTheBallsAsTheLensBendsIt) {
  for (const Scene& scene : scenes()) {
    const sim::Optics optics(scene);
    const auto [width, height] = optics.sensor();
    const auto settings = host::digitize_settings(host_rig(scene), width, height);
    CHECK_TEXT(settings.has_value(), settings ? "" : settings.error().message.c_str());
    const sim::CameraSettings& camera = scene.camera;
    const double turn = camera.roll_rad + (camera.mirrored ? -1.0 : 1.0) * scene.surface_angle_rad;
    for (const double column : {0.2 * width, 0.5 * width, 0.8 * width}) {
      for (const double row : {0.2 * height, 0.5 * height, 0.8 * height}) {
        const sim::Vec2 seen = optics.plane_at(column, row);
        const double y = seen.y + 0.5 * camera.height_m;
        const cv::Point2d plane = settings->map.to_plane({column, row});
        // A hundredth of a px: seven digits of a few thousand px are written.
        DOUBLES_EQUAL(camera.origin_x_px + camera.px_per_m * (std::cos(turn) * seen.x - std::sin(turn) * y),
                      plane.x, 0.01);
        DOUBLES_EQUAL(camera.origin_y_px + camera.px_per_m * (std::sin(turn) * seen.x + std::cos(turn) * y),
                      plane.y, 0.01);
      }
    }
    CHECK_EQUAL(optics.perspective(), settings->map.viewpoint().has_value());
  }
}

TEST(RigFileOfAScene, LeavesTheUsualTrainWhereBallsFlyAsUsual) {
  const auto usual = sim::load_scene(STROBE_SCENES_FOLDER "/zero_23.toml");
  const auto fast = sim::load_scene(STROBE_SCENES_FOLDER "/extreme_fastest.toml");
  const auto slow = sim::load_scene(STROBE_SCENES_FOLDER "/extreme_slowest.toml");
  const auto period_us = [](const Scene& scene) {
    return to_seconds(firmware::read_rig(sim::rig_file_text(scene, {}), "rig.toml")->plan.period) * 1e6;
  };
  DOUBLES_EQUAL(3000, period_us(*usual), 1e-6);
  DOUBLES_EQUAL(1500, period_us(*fast), 1e-6);  // 51 mm at 60 m/s are 850 us: the lamps' shortest period
  DOUBLES_EQUAL(10000, period_us(*slow), 1e-6);
}

TEST(RigFileOfAScene, CarriesWhatTheRunWasGiven) {
  const Scene scene = scenes().front();
  const std::string odd = "a \"b\" \\ c\t/photos";
  const host::RigFile rig = host_rig(scene, {.rig_name = "lab-2",
                                             .lcm_url = "udpm://239.1.1.1:7000?ttl=0",
                                             .key_file = "lab.key",
                                             .photographs = odd});
  CHECK_EQUAL("lab-2", rig.rig);
  CHECK_EQUAL("udpm://239.1.1.1:7000?ttl=0", rig.lcm_url.value_or(""));
  CHECK_EQUAL("lab.key", rig.key_file.value_or(""));
  CHECK_EQUAL(odd, rig.camera.folder.value_or(""));
}

TEST(RigFileOfAScene, NamesTheCameraOnTheNetworkIfThereIsOne) {
  const Scene scene = scenes().front();
  CHECK_TRUE(sim::rig_file_text(scene, {}).find("genicam") == std::string::npos);
  const std::string text = sim::rig_file_text(
      scene, {.camera_kind = "genicam", .camera_address = "127.0.1.7", .camera_serial = "SIM-7F000107"});
  for (const char* entry : {"\nkind = \"genicam\" ", "\nserial = \"SIM-7F000107\"\n",
                            "\naddress = \"127.0.1.7\" ", "\nexposure = \"line\" "})
    STRCMP_CONTAINS(entry, text.c_str());
}

TEST_GROUP(WritingARigFile) {
  testing::TemporaryFolder folder;
  Scene scene = *sim::load_scene(STROBE_SCENES_FOLDER "/zero_23.toml");
};

TEST(WritingARigFile, MakesFoldersAndWritesPathsFromTheFile) {
  const fs::path file = folder / "lab/rig.toml";
  CHECK(sim::write_rig_file(file, scene, photographs_in(folder / "lab/photos")).has_value());
  CHECK(fs::is_directory(folder / "lab/photos"));
  CHECK_EQUAL("photos", host::read_rig(testing::read_text(file), "rig.toml")->camera.folder.value_or(""));
  CHECK_EQUAL((folder / "lab/photos").string(), host::load_rig(file.string())->camera.folder.value_or(""));
}

TEST(WritingARigFile, KeepsTheWholePathOfAFolderElsewhere) {
  CHECK(sim::write_rig_file(folder / "lab/rig.toml", scene, photographs_in(folder / "photos")).has_value());
  CHECK_EQUAL((folder / "photos").string(),
              host::load_rig((folder / "lab/rig.toml").string())->camera.folder.value_or(""));
}

TEST(WritingARigFile, DoesNotOverwriteWhatAPersonChanged) {
  const fs::path file = folder / "rig.toml";
  CHECK(sim::write_rig_file(file, scene, {}).has_value());
  CHECK(sim::write_rig_file(file, scene, {}).has_value());  // the same again
  const std::string changed = testing::read_text(file) + "# my own\n";
  testing::write_text(file, changed);
  const auto refused = sim::write_rig_file(file, scene, {});
  CHECK_FALSE(refused.has_value());
  STRCMP_CONTAINS("rig.toml: is there already", refused.error().message.c_str());
  CHECK_EQUAL(changed, testing::read_text(file));
}

TEST(RigFileOfAScene, UndoesATurnedCamera) {
  auto scene = sim::load_scene("photo_close_lens");
  scene->camera.distortion = 0.0;
  scene->camera.swing_rad = 0.05;
  scene->camera.tilt_rad = -0.03;
  const auto settings = host::digitize_settings(host_rig(*scene), sim::sensor_size(*scene).width,
                                                sim::sensor_size(*scene).height);
  CHECK_TEXT(settings.has_value(), settings ? "" : settings.error().message.c_str());
  const sim::Optics optics(*scene);
  const auto plane = [&](double column, double row) { return settings->map.to_plane({column, row}); };
  const sim::Vec2 a = optics.plane_at(100, 200), b = optics.plane_at(1500, 900);
  // The file's numbers have seven digits where a place is meant, twelve in the map.
  DOUBLES_EQUAL(std::hypot(b.x - a.x, b.y - a.y) * scene->camera.px_per_m,
                cv::norm(plane(1500, 900) - plane(100, 200)), 1e-2);
}
