// The shipped driver, spoken to as strobe does it, with the simulated PTP/IP camera and with a folder. In the
// machine's time: what is waited for may take its time, and nothing is judged by it.
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "host/tether/camera_driver.hpp"
#include "sim/loading/load_scene.hpp"
#include "sim/ptp/ptp_camera.hpp"
#include "sim/shoot/shoot.hpp"
#include "tests/support/process.hpp"
#include "tests/support/temporary_folder.hpp"

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe;
using namespace strobe::tether;
using namespace std::chrono_literals;
namespace fs = std::filesystem;

constexpr auto kLimit = 60s;
const std::string kDriver = std::string(STROBE_BUILD_DIR) + "/bin/strobe-camera-gphoto2";
const std::string kAddress = "127.0.7.1";

sim::Scene tiny_scene(const std::string& more) {
  auto scene = sim::parse_scene(
      "[machine]\nspeed_mps = 17\nangle_deg = -23\nspin_radps = 0\n"
      "[bounce]\ne = 0.8\nmu = 0.6\ndwell_ms = 5\n"
      "[camera]\npx_per_m = 200\norigin_x_px = 75\norigin_y_px = 15\n" +
          more,
      "tiny.toml");
  if (!scene) FAIL(scene.error().message.c_str());
  return *scene;
}

}  // namespace

TEST_GROUP(Gphoto2Driver) {
  strobe::testing::TemporaryFolder folder;
  sim::ExposureStore exposure_store;
  sim::Scene scene = tiny_scene("");
  std::unique_ptr<sim::ptp::PtpCamera> camera;
  std::unique_ptr<CameraDriver> driver;
  std::vector<Event> events;
  std::size_t taken = 0;  ///< of them

  void setup() override {
    setenv("HOME", folder.path().c_str(), 1);  // where libgphoto2 keeps its settings
    setenv("TMPDIR", folder.path().c_str(), 1);
    fs::create_directory(folder / "photographs");
    auto started = CameraDriver::start(kDriver);
    if (!started) FAIL(started.error().message.c_str());
    driver = std::move(*started);
  }
  void teardown() override { unsetenv("TMPDIR"); }

  void switch_camera_on(const std::string& more = "") {
    scene = tiny_scene(more);
    auto created = sim::ptp::PtpCamera::create(kAddress, scene, 4, exposure_store);
    if (!created) FAIL(created.error().message.c_str());
    camera = std::move(*created);
    camera->start(false);
  }
  /// That of the shot, its shutter just closed.
  void expose(int shot) {
    auto made = sim::shoot(scene, 4, shot);
    if (!made) FAIL(made.error().message.c_str());
    const Duration shift = sim::RigClock{}.now() - made->exposure.closed;
    made->exposure.opened = made->exposure.opened + shift;
    made->exposure.closed = made->exposure.closed + shift;
    exposure_store.add(made->exposure);
  }
  void open(const std::map<std::string, std::string>& set = {}, bool delete_from_camera = false,
            const std::string& address = "ptpip:" + kAddress) {
    OpenRequest request;
    request.address = address;
    request.set = set;
    request.folder = folder / "photographs";
    request.delete_from_camera = delete_from_camera;
    driver->send(request);
  }
  /// The next event of that kind; those before it are passed over.
  template <typename Kind>
  Kind next() {
    std::optional<Kind> found;
    strobe::testing::wait_until(
        [&] {
          for (Event& event : driver->take_events()) events.push_back(std::move(event));
          while (!found && taken < events.size()) {
            if (const auto* event = std::get_if<Kind>(&events[taken++])) found = *event;
          }
          return found || !driver->ended().empty();
        },
        kLimit);
    if (!found) FAIL(("no such event; " + driver->ended()).c_str());
    return *found;
  }
  std::string settings_of(const OpenedEvent& opened) const {
    std::string text;
    for (const Setting& setting : opened.settings) {
      if (!setting.asked.empty())
        text += setting.name + " " + std::string(name(setting.state)) + " " + setting.is + "\n";
    }
    return text;
  }
  static std::string problems_of(const OpenedEvent& opened) {
    std::string text;
    for (const Problem& problem : opened.problems) text += (problem.prevents ? "!" : "") + problem.text + "\n";
    return text;
  }
  std::set<std::string> photographs() const {
    std::set<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder / "photographs")) names.insert(entry.path().filename());
    return names;
  }
  std::set<std::string> files_on_card() const {
    std::set<std::string> names;
    for (const auto& entry : fs::recursive_directory_iterator(folder.path())) {
      if (entry.path().string().find("strobe-sim-card") != std::string::npos && entry.is_regular_file())
        names.insert(entry.path().filename());
    }
    return names;
  }
};

TEST(Gphoto2Driver, OpensTheCameraAndTellsHowItIsSet) {
  switch_camera_on();
  open({{"iso", "150"}, {"f-number", "5.6"}, {"batterylevel", "9"}, {"nothing", "1"}, {"longexpnr", "On"}});
  const OpenedEvent opened = next<OpenedEvent>();
  CHECK_EQUAL("Simulated PTP camera", opened.camera.model);
  CHECK_EQUAL(sim::ptp::serial_of(kAddress), opened.camera.serial);
  CHECK_FALSE(opened.has_clock);
  const std::string settings = settings_of(opened);
  for (const char* line : {"iso rounded ", "f-number as_asked f/5.6\n", "batterylevel refused 90%\n",
                           "nothing absent \n", "longexpnr as_asked On\n", "isoauto as_asked Off\n"})
    STRCMP_CONTAINS(line, settings.c_str());
  STRCMP_CONTAINS("long-exposure noise reduction is on", problems_of(opened).c_str());
  driver->send(CheckRequest{});
  next<ReadyEvent>();
}

TEST(Gphoto2Driver, TellsASoundCameraWithoutProblems) {
  switch_camera_on();
  open();
  CHECK_EQUAL("", problems_of(next<OpenedEvent>()));
}

TEST(Gphoto2Driver, TakesNewPhotographsOverAndLeavesOldOnesAlone) {
  switch_camera_on();
  expose(1);
  CHECK(strobe::testing::wait_until([&] { return files_on_card().contains("DSC_0001.TIF"); }, kLimit));
  open();
  next<OpenedEvent>();
  expose(2);
  const PhotographEvent photograph = next<PhotographEvent>();
  CHECK_EQUAL("DSC_0002.TIF", photograph.file);
  LONGS_EQUAL(2, photograph.number);
  CHECK_FALSE(photograph.exposed.has_value());
  CHECK_EQUAL(std::set<std::string>{"DSC_0002.TIF"}, photographs());
  const std::set<std::string> both{"DSC_0001.TIF", "DSC_0002.TIF"};
  CHECK_EQUAL(both, files_on_card());
}

TEST(Gphoto2Driver, TakesTheRawOfAPairAndDeletesBothIfToldTo) {
  switch_camera_on();
  open({{"imagequality", "NEF+Fine"}}, true);
  STRCMP_CONTAINS("a JPEG beside each RAW", problems_of(next<OpenedEvent>()).c_str());
  expose(1);
  CHECK_EQUAL("DSC_0001.TIF", next<PhotographEvent>().file);
  expose(2);
  CHECK_EQUAL("DSC_0002.TIF", next<PhotographEvent>().file);
  CHECK(strobe::testing::wait_until([&] { return files_on_card().empty(); }, kLimit));
  const std::set<std::string> both{"DSC_0001.TIF", "DSC_0002.TIF"};
  CHECK_EQUAL(both, photographs());
}

TEST(Gphoto2Driver, TakesAJpegWhereTheCameraWritesNothingElse) {
  switch_camera_on();
  open({{"imagequality", "JPEG Fine"}});
  STRCMP_CONTAINS("it writes no RAW files", problems_of(next<OpenedEvent>()).c_str());
  expose(1);
  CHECK_EQUAL("DSC_0001.JPG", next<PhotographEvent>().file);
}

TEST(Gphoto2Driver, NeverWritesOverAnOlderPhotograph) {
  strobe::testing::write_text(folder / "photographs/DSC_0001.TIF", "of yesterday");
  switch_camera_on();
  open();
  next<OpenedEvent>();
  expose(1);
  CHECK_EQUAL("DSC_0001-2.TIF", next<PhotographEvent>().file);
  CHECK_EQUAL("of yesterday", strobe::testing::read_text(folder / "photographs/DSC_0001.TIF"));
}

TEST(Gphoto2Driver, TakesOverWhatWasMadeWhileTheCameraWasAway) {
  switch_camera_on("[[fault]]\nkind = \"camera_vanishes\"\nshot = 1\ndelay_s = 2\n");
  open();
  next<OpenedEvent>();
  expose(1);
  next<GoneEvent>();
  driver->send(CheckRequest{});
  next<GoneEvent>();
  expose(2);
  next<OpenedEvent>();
  std::set<std::string> files{next<PhotographEvent>().file};
  files.insert(next<PhotographEvent>().file);
  const std::set<std::string> both{"DSC_0001.TIF", "DSC_0002.TIF"};
  CHECK_EQUAL(both, files);
}

TEST(Gphoto2Driver, TellsAFullCardAndALowBattery) {
  switch_camera_on("[[fault]]\nkind = \"card_full\"\nshot = 1\n[[fault]]\nkind = \"battery_low\"\nshot = 1\n");
  open();
  next<OpenedEvent>();
  expose(1);
  CHECK_EQUAL("the camera's card is full", next<LostEvent>().why);
  const std::string problems = problems_of(next<OpenedEvent>());
  STRCMP_CONTAINS("!its card is full", problems.c_str());
  STRCMP_CONTAINS("its battery is at 8%", problems.c_str());
}

TEST(Gphoto2Driver, TellsAnExposureOfWhichNoFileComes) {
  switch_camera_on("[[fault]]\nkind = \"no_photograph\"\nshot = 1\n");
  open();
  next<OpenedEvent>();
  expose(1);
  STRCMP_CONTAINS("of an exposure, but of no file", next<NoteEvent>().text.c_str());
}

TEST(Gphoto2Driver, TakesAPictureOfTheLengthAskedForAndSetsBulbAgain) {
  switch_camera_on();
  open();
  next<OpenedEvent>();
  driver->send(SnapRequest{0.012});
  CHECK_EQUAL("DSC_0001.TIF", next<PhotographEvent>().file);
  open({{"shutterspeed", "bulb"}});
  STRCMP_CONTAINS("shutterspeed as_asked Bulb", settings_of(next<OpenedEvent>()).c_str());
}

TEST(Gphoto2Driver, SaysWhatItCannotOpen) {
  open({}, false, "ptpip:127.0.7.99");
  STRCMP_CONTAINS("ptpip:127.0.7.99", next<FailedEvent>().why.c_str());
  open({}, false, "nonsense");
  STRCMP_CONTAINS("nonsense", next<FailedEvent>().why.c_str());
  driver->send(SnapRequest{0.01});
  CHECK_EQUAL("no camera is open", next<FailedEvent>().why);
  driver->send(ListRequest{});
  next<CamerasEvent>();
  CHECK_EQUAL("", driver->ended());
}

TEST(Gphoto2Driver, FindsNewFilesOfAFolderOnceTheyGrowNoMore) {
  fs::create_directories(folder / "card/DCIM/100CANON");
  strobe::testing::write_text(folder / "card/DCIM/100CANON/IMG_0001.CR2", "old");
  open({}, false, "disk:" + (folder / "card").string());
  CHECK_EQUAL("Directory Browse", next<OpenedEvent>().camera.model);
  strobe::testing::write_text(folder / "card/DCIM/100CANON/IMG_0002.CR2", "new");
  CHECK_EQUAL("IMG_0002.CR2", next<PhotographEvent>().file);
  CHECK_EQUAL("new", strobe::testing::read_text(folder / "photographs/IMG_0002.CR2"));
  fs::create_directories(folder / "card/DCIM/101CANON");
  strobe::testing::write_text(folder / "card/DCIM/101CANON/IMG_0001.CR2", "again");
  CHECK_EQUAL("IMG_0001.CR2", next<PhotographEvent>().file);
  const std::set<std::string> both{"IMG_0001.CR2", "IMG_0002.CR2"};
  CHECK_EQUAL(both, photographs());
}
