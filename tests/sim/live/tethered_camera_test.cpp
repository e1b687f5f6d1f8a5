// The rig's camera, which writes what the exposure store's exposures show.
#include "sim/live/tethered_camera.hpp"
#include "sim/loading/load_scene.hpp"

#include <set>
#include <string>

#include "sim/photograph/appearance.hpp"
#include "sim/shoot/shoot.hpp"
#include "tests/support/pictures.hpp"
#include "tests/support/process.hpp"
#include "tests/support/temporary_folder.hpp"

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe;
using namespace strobe::sim;
using namespace std::chrono_literals;
namespace fs = std::filesystem;

Scene tiny_scene(const std::string& more = "") {
  auto scene = parse_scene(
      "[machine]\nspeed_mps = 17\nangle_deg = -23\nspin_radps = 0\n"
      "[bounce]\ne = 0.8\nmu = 0.6\ndwell_ms = 5\n"
      "[camera]\npx_per_m = 200\norigin_x_px = 75\norigin_y_px = 15\n" +
          more,
      "tiny.toml");
  if (!scene) FAIL(scene.error().message.c_str());
  return *scene;
}

}  // namespace

TEST_GROUP(TetheredCamera) {
  strobe::testing::TemporaryFolder folder;
  ExposureStore exposure_store;
  std::unique_ptr<sim::TetheredCamera> tethered_camera;

  void start(const Scene& scene) {
    auto created = sim::TetheredCamera::create(folder / "camera", scene, 4, exposure_store);
    if (!created) FAIL(created.error().message.c_str());
    tethered_camera = std::move(*created);
    tethered_camera->start(true);
  }
  void stop() { CHECK_TRUE(tethered_camera->stop().has_value()); }
  /// That of the shot, its shutter just closed.
  Exposure exposure(const Scene& scene, int shot) {
    auto made = shoot(scene, 4, shot);
    if (!made) FAIL(made.error().message.c_str());
    const Duration shift = RigClock{}.now() - made->exposure.closed;
    made->exposure.opened = made->exposure.opened + shift;
    made->exposure.closed = made->exposure.closed + shift;
    return made->exposure;
  }
  std::set<std::string> files() const {
    std::set<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder / "camera")) names.insert(entry.path().filename());
    return names;
  }
  void check_files(const std::set<std::string>& expected) { CHECK_EQUAL(expected, files()); }
};

TEST(TetheredCamera, WritesAPhotographOfEachExposureAsItEnds) {
  const Scene scene = tiny_scene();
  start(scene);
  exposure_store.add(exposure(scene, 1));
  CHECK(strobe::testing::wait_until([&] { return files().contains("exposure-0001.tif"); }, 20s));
  exposure_store.add(exposure(scene, 2));
  CHECK(strobe::testing::wait_until([&] { return files().contains("exposure-0002.tif"); }, 20s));
  stop();
  check_files({"exposure-0001.tif", "exposure-0002.tif"});
  const cv::Mat read = strobe::testing::read_picture(folder / "camera/exposure-0002.tif");
  LONGS_EQUAL(sensor_size(scene).width, read.cols);
  LONGS_EQUAL(sensor_size(scene).height, read.rows);
}

TEST(TetheredCamera, NeverWritesOverAnOlderFile) {
  fs::create_directory(folder / "camera");
  strobe::testing::write_text(folder / "camera/exposure-0001.tif", "of yesterday");
  strobe::testing::write_text(folder / "camera/exposure-0003.tif", "of yesterday");
  const Scene scene = tiny_scene();
  start(scene);
  exposure_store.add(exposure(scene, 1));
  exposure_store.add(exposure(scene, 2));
  stop();
  check_files({"exposure-0001.tif", "exposure-0002.tif", "exposure-0003.tif", "exposure-0004.tif"});
  for (const char* name : {"camera/exposure-0001.tif", "camera/exposure-0003.tif"})
    CHECK_EQUAL("of yesterday", strobe::testing::read_text(folder / name));
}

TEST(TetheredCamera, WritesWhatIsStillDueWhenItIsStopped) {
  const Scene scene = tiny_scene("[[fault]]\nkind = \"frame_late\"\ndelay_s = 60\n");
  start(scene);
  exposure_store.add(exposure(scene, 1));
  strobe::testing::sleep_for(100ms);
  check_files({});
  stop();
  check_files({"exposure-0001.tif"});
}

TEST(TetheredCamera, MakesNoneWhereTheShutterStayedShutOrTheSceneSaysSo) {
  const Scene scene = tiny_scene("[[fault]]\nkind = \"no_photograph\"\nshot = 2\n");
  start(scene);
  Exposure shut = exposure(scene, 1);
  shut.opened = kNoTime;
  exposure_store.add(shut);
  exposure_store.add(exposure(scene, 2));
  exposure_store.add(exposure(scene, 3));
  stop();
  check_files({"exposure-0001.tif"});
}

TEST(TetheredCamera, SaysWhatCannotBeWritten) {
  strobe::testing::write_text(folder / "file", "x");
  const auto none = sim::TetheredCamera::create(folder / "file/camera", tiny_scene(), 4, exposure_store);
  CHECK_FALSE(none.has_value());
  STRCMP_CONTAINS("no folder that photographs can be written to", none.error().message.c_str());
  const auto huge = sim::TetheredCamera::create(
      folder / "camera", tiny_scene("[photograph]\nwidth_px = 20000\nheight_px = 20000\n"), 4,
      exposure_store);
  CHECK_FALSE(huge.has_value());
  STRCMP_CONTAINS("20000 x 20000", huge.error().message.c_str());
  const Scene scene = tiny_scene();
  start(scene);
  fs::remove_all(folder / "camera");
  exposure_store.add(exposure(scene, 1));
  const auto stopped = tethered_camera->stop();
  CHECK_FALSE(stopped.has_value());
  STRCMP_CONTAINS("exposure-0001.tif: cannot be written", stopped.error().message.c_str());
}
