// The shipped driver and Aravis' own simulated camera, which knows nothing of a shutter line, keeps no time and
// sends no packet again: its frames are told to come, or come all the time.
#include <fcntl.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include "common/config/files.hpp"
#include "common/image/image_files.hpp"
#include "host/tether/driver_messages.hpp"
#include "tests/support/process.hpp"
#include "tests/support/skip.hpp"
#include "tests/support/string_from.hpp"
#include "tests/support/temporary_folder.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::testing;
using namespace strobe::tether;
using namespace std::chrono_literals;

namespace {

constexpr auto kPatience = 60s;
constexpr const char* kFakeCamera = "arv-fake-gv-camera-0.8";

bool has_fake_camera() {
  const std::string paths = std::getenv("PATH");
  for (std::size_t at = 0; at <= paths.size();) {
    const std::size_t end = std::min(paths.find(':', at), paths.size());
    if (access((paths.substr(at, end - at) + "/" + kFakeCamera).c_str(), X_OK) == 0) return true;
    at = end + 1;
  }
  return false;
}

/// A driver that is spoken with.
class Conversation {
 public:
  explicit Conversation(const TemporaryFolder& folder) : input_path_(folder / "requests") {
    if (mkfifo(input_path_.c_str(), 0600) != 0) throw std::runtime_error("no pipe");
    driver_ = std::make_unique<Process>(
        Command{.arguments = {"sh", "-c", "exec \"$0\" < \"$1\"", STROBE_GENICAM_DRIVER, input_path_.string()}},
        folder.path());
    input_ = open(input_path_.c_str(), O_WRONLY | O_CLOEXEC);
  }
  ~Conversation() { hang_up(); }

  void say(const Request& request) const {
    if (!config::write_all(input_, to_line(request) + "\n")) throw std::runtime_error("the driver has ended");
  }
  void hang_up() {
    if (input_ >= 0) close(input_);
    input_ = -1;
  }
  Process& driver() { return *driver_; }

  /// The next that is of this kind and has not been taken; others between are passed over.
  template <typename Kind>
  Kind next() {
    std::optional<Kind> found;
    wait_until([&] { return found.has_value() || take(found); }, kPatience);
    if (!found) throw std::runtime_error("the driver did not say it, but: " + driver_->out() + driver_->err());
    return *found;
  }

 private:
  template <typename Kind>
  bool take(std::optional<Kind>& found) {
    const std::string said = driver_->out();
    for (std::size_t end = said.find('\n', at_); !found && end != std::string::npos; end = said.find('\n', at_)) {
      const auto event = parse_event(said.substr(at_, end - at_));
      CHECK_TEXT(event.has_value(), said.substr(at_, end - at_).c_str());
      at_ = end + 1;
      if constexpr (std::is_same_v<Kind, Event>) {
        found = *event;
      } else if (const auto* kind = std::get_if<Kind>(&*event)) {
        found = *kind;
      }
    }
    return found.has_value();
  }

  std::filesystem::path input_path_;
  std::unique_ptr<Process> driver_;
  int input_ = -1;
  std::size_t at_ = 0;
};

const Setting* find(const OpenedEvent& opened, const std::string& name) {
  const auto found = std::ranges::find(opened.settings, name, &Setting::name);
  return found == opened.settings.end() ? nullptr : &*found;
}

std::string problems_of(const OpenedEvent& opened) {
  std::string all;
  for (const Problem& problem : opened.problems) all += (problem.prevents ? "! " : "") + problem.text + "\n";
  return all;
}

}  // namespace

TEST_GROUP(GenicamDriver) {
  const TemporaryFolder folder;
  std::unique_ptr<Process> camera;
  std::unique_ptr<Conversation> driver;

  bool started() {
    if (!has_fake_camera()) {
      skip(std::string(kFakeCamera) + " is not installed");
      return false;
    }
    start_camera();
    driver = std::make_unique<Conversation>(folder);
    return true;
  }
  /// Until it listens.
  void start_camera() {
    camera = std::make_unique<Process>(Command{.arguments = {kFakeCamera, "-i", "127.0.0.1"}}, folder.path());
    const auto listens = [] { return read_text("/proc/net/udp").find(":0F74 ") != std::string::npos; };
    CHECK_TRUE(wait_until(listens, kPatience));
  }
  OpenRequest request() const {
    OpenRequest open;
    open.address = "127.0.0.1";
    open.exposure_s = 0.004;
    open.folder = folder.path().string();
    return open;
  }
  OpenedEvent open(const OpenRequest& wanted) {
    driver->say(wanted);
    return driver->next<OpenedEvent>();
  }
  /// On a computer so busy that the camera stops amidst a frame it is taken again.
  image::Raster snapshot() {
    for (int i = 0; i < 10; ++i) {
      driver->say(SnapRequest{0.01});
      while (true) {
        const Event event = driver->next<Event>();
        if (const auto* photograph = std::get_if<PhotographEvent>(&event)) return picture(*photograph);
        if (std::holds_alternative<FailedEvent>(event)) break;
      }
    }
    throw std::runtime_error("no snapshot has come");
  }
  image::Raster picture(const PhotographEvent& photograph) const {
    const std::string bytes = read_text(folder / photograph.file);
    auto raster =
        image::decode_tiff({reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()});
    CHECK_TEXT(raster.has_value(), raster ? "" : raster.error().message.c_str());
    return std::move(*raster);
  }
};

TEST(GenicamDriver, FindsTheCameraAndSaysWhatItCannotDo) {
  if (!started()) return;
  driver->say(ListRequest{});
  const CamerasEvent found = driver->next<CamerasEvent>();
  LONGS_EQUAL(1, found.cameras.size());
  CHECK_EQUAL("GV01", found.cameras.front().serial);
  const OpenedEvent opened = open(request());
  CHECK_EQUAL("Aravis", opened.camera.vendor);
  CHECK_EQUAL("GV01", opened.camera.serial);
  CHECK_EQUAL("127.0.0.1", opened.camera.address);
  CHECK_EQUAL("0.004 s from the edge of Line0 on (Timed)", opened.exposure);
  CHECK_FALSE(opened.has_clock);
  CHECK_EQUAL("Mono16", find(opened, "PixelFormat")->is);
  CHECK_EQUAL("On", find(opened, "TriggerMode")->is);
  CHECK_TRUE(find(opened, "ExposureMode")->state == SettingState::absent);
  const std::string problems = problems_of(opened);
  STRCMP_CONTAINS("it cannot expose while the line is active", problems.c_str());
  STRCMP_CONTAINS("it does not send missing packets again", problems.c_str());
  CHECK_FALSE(problems.starts_with("! "));
}

TEST(GenicamDriver, IsFoundBySerialNumberAndAnotherOneIsNot) {
  if (!started()) return;
  OpenRequest other = request();
  other.address.clear();
  other.serial = "GV01";
  driver->say(other);
  CHECK_EQUAL("GV01", driver->next<OpenedEvent>().camera.serial);
  other.serial = "GV02";
  driver->say(other);
  CHECK_EQUAL("no camera with the serial number GV02 is found", driver->next<FailedEvent>().why);
  other.address = "127.0.0.1";
  driver->say(other);
  CHECK_EQUAL("127.0.0.1: the camera there has the serial number GV01 instead of GV02",
              driver->next<FailedEvent>().why);
}

TEST(GenicamDriver, SnapshotIsTakenWithoutTheLineAndLeavesTheCameraArmed) {
  if (!started()) return;
  open(request());
  for (int i = 0; i < 2; ++i) {
    const image::Raster raster = snapshot();
    LONGS_EQUAL(512, raster.width());
    LONGS_EQUAL(512, raster.height());
    LONGS_EQUAL(16, raster.bits());
  }
  driver->say(request());
  CHECK_EQUAL("Line0", find(driver->next<OpenedEvent>(), "TriggerSource")->is);
}

TEST(GenicamDriver, EveryFrameIsAPhotographAlsoWhereTheCameraCountsAnew) {
  if (!started()) return;
  OpenRequest all_the_time = request();
  all_the_time.set = {{"TriggerMode", "Off"}, {"Width", "64"}, {"Height", "48"}, {"AcquisitionFrameRate", "100"}};
  const OpenedEvent opened = open(all_the_time);
  CHECK_EQUAL("Off", find(opened, "TriggerMode")->is);
  CHECK_EQUAL("64", find(opened, "Width")->asked);
  PhotographEvent photograph = driver->next<PhotographEvent>();
  std::int64_t number = photograph.number;
  std::set<std::string> names;
  // Its ids begin at 65401, 135 frames before they begin again. A busy computer may lose some, and says so.
  while (names.size() < 150) {
    const Event event = driver->next<Event>();
    if (const auto* lost = std::get_if<LostEvent>(&event)) LONGS_EQUAL(++number, lost->number);
    if (const auto* next = std::get_if<PhotographEvent>(&event)) {
      LONGS_EQUAL(++number, next->number);
      CHECK_TRUE(names.insert(next->file).second);
      photograph = *next;
    }
  }
  CHECK_TRUE(photograph.number > 65535);
  const image::Raster raster = picture(photograph);
  LONGS_EQUAL(64, raster.width());
  LONGS_EQUAL(48, raster.height());
}

TEST(GenicamDriver, WhatTheCameraLacksOrRefusesIsTold) {
  if (!started()) return;
  OpenRequest wanted = request();
  wanted.set = {{"Gain", "1"}, {"TriggerActivation", "FallingEdge"}, {"BinningVertical", "two"}};
  const OpenedEvent opened = open(wanted);
  CHECK_TRUE(find(opened, "Gain")->state == SettingState::absent);
  CHECK_TRUE(find(opened, "TriggerActivation")->state == SettingState::refused);
  CHECK_TRUE(find(opened, "BinningVertical")->state == SettingState::refused);
  const std::string problems = problems_of(opened);
  STRCMP_CONTAINS("! Gain is absent instead of 1: the rig file asks for it", problems.c_str());
  STRCMP_CONTAINS("TriggerActivation is RisingEdge instead of FallingEdge", problems.c_str());
  STRCMP_CONTAINS("\"two\" is no whole number", problems.c_str());
}

TEST(GenicamDriver, CameraThatVanishesIsLookedForAndSetAnew) {
  if (!started()) return;
  open(request());
  camera->signal(SIGKILL);
  CHECK_TRUE(camera->wait(kPatience).has_value());
  CHECK_EQUAL("the camera does not answer", driver->next<GoneEvent>().why);
  driver->say(SnapRequest{0.01});
  CHECK_EQUAL("no camera is open", driver->next<FailedEvent>().why);
  start_camera();
  CHECK_EQUAL("On", find(driver->next<OpenedEvent>(), "TriggerMode")->is);
  STRCMP_CONTAINS("what it exposed then is lost", driver->next<NoteEvent>().text.c_str());
  LONGS_EQUAL(512, snapshot().width());
}

TEST(GenicamDriver, EndsWithItsInputAndWithoutSpeakingToTheTerminal) {
  if (!started()) return;
  open(request());
  driver->hang_up();
  const auto status = driver->driver().wait(kPatience);
  CHECK_TRUE(status.has_value());
  CHECK_EQUAL(ExitStatus{.code = 0}, *status);
  CHECK_EQUAL("", driver->driver().err());
}

TEST(GenicamDriver, AnsweringWithoutACameraIsNoFault) {
  driver = std::make_unique<Conversation>(folder);
  OpenRequest any;
  any.folder = folder.path().string();
  driver->say(any);
  CHECK_EQUAL("no camera is found", driver->next<FailedEvent>().why);
}
