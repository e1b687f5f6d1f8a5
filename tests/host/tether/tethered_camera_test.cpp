// A camera behind drivers that are shell scripts: what they say, and that they end, hang or babble, is scripted.
#include "host/tether/tethered_camera.hpp"

#include <poll.h>
#include <sys/stat.h>

#include <functional>
#include <string>

#include "tests/support/process.hpp"
#include "tests/support/temporary_folder.hpp"

#include "tests/support/string_from.hpp"

namespace {

namespace fs = std::filesystem;
using namespace strobe;
using namespace strobe::tether;

constexpr const char* kOpened =
    R"({"event":"opened","camera":{"vendor":"Maker","model":"M1","serial":"S7","firmware":"1","address":""},)"
    R"("exposure":"by the line","has_clock":true,"settings":[],"problems":[]})";

/// Answers each request by the case that names it.
std::string driver(const std::string& on_open, const std::string& on_check) {
  return "#!/bin/bash\nwhile read -r line; do\n  case \"$line\" in\n    *'\"open\"'*) " + on_open + " ;;\n    *'\"check\"'*) " +
         on_check + " ;;\n  esac\ndone\n";
}
std::string says(const std::string& event) { return "echo '" + event + "'"; }

}  // namespace

TEST_GROUP(TetheredCameras) {
  testing::TemporaryFolder folder;
  HostTime now{std::chrono::seconds{100}};
  std::unique_ptr<TetheredCamera> camera;
  std::string told;

  void start(const std::string& script) {
    const fs::path program = folder / "driver";
    testing::write_text(program, script);
    chmod(program.c_str(), 0755);
    OpenRequest open;
    open.folder = folder.path().string();
    auto started = TetheredCamera::start(program, open, now);
    CHECK_TRUE(started.has_value());
    camera = std::move(*started);
  }
  void step() {
    camera->step(now);
    for (const std::string& text : camera->take_notifications()) told += text + "\n";
  }
  /// The camera's time stands still meanwhile; nothing but the driver is waited for, be it on a busy machine.
  void until(const std::function<bool()>& condition) {
    int silent = 0;
    for (step(); !condition(); step()) {
      pollfd wait{camera->descriptor(), POLLIN, 0};
      silent = poll(&wait, 1, 100) > 0 ? 0 : silent + 1;
      if (silent > 600) FAIL(("the driver is silent; it was told:\n" + told).c_str());
    }
  }
  void ready() {
    until([this] { return camera->problem(now).empty(); });
  }
  /// One second on, the question of which is answered.
  void answer() {
    now += std::chrono::seconds{1};
    ready();
  }
};

TEST(TetheredCameras, AreReadyOnceTheyAreOpenAndAsLongAsTheyAnswer) {
  start(driver(says(kOpened), says(R"({"event":"ready"})")));
  STRCMP_EQUAL("the camera is being opened", camera->problem(now).c_str());
  ready();
  STRCMP_CONTAINS("camera: Maker M1 S7 is ready, exposes by the line", told.c_str());
  for (int i = 0; i < 3; ++i) answer();
}

TEST(TetheredCameras, ThatDoNotAnswerAreNotReady) {
  start(driver(says(kOpened), "true"));
  ready();
  now += std::chrono::seconds{3};
  step();
  STRCMP_EQUAL("the camera has not answered for 3 s", camera->problem(now).c_str());
}

TEST(TetheredCameras, WhoseSettingsSpoilThePhotographsAreNotReady) {
  const std::string opened = kOpened;
  start(driver(says(opened.substr(0, opened.find("\"problems\"")) +
                    R"("problems":[{"prevents":false,"text":"battery low"},{"prevents":true,"text":"card full"}]})"),
               says(R"({"event":"ready"})")));
  until([this] { return camera->opened().has_value(); });
  STRCMP_EQUAL("card full", camera->problem(now).c_str());
  STRCMP_CONTAINS("camera: battery low", told.c_str());
}

TEST(TetheredCameras, TellWhatTheCameraMadeOfASettingAndWhatChanges) {
  const std::string opened = kOpened;
  const std::string head = opened.substr(0, opened.find("\"settings\"")) + "\"settings\":[";
  const auto with = [&head](const std::string& settings) { return says(head + settings + "],\"problems\":[]}"); };
  const std::string rounded = R"({"name":"Gain","asked":"1","is":"1.2","state":"rounded","remark":"in steps of .4"})";
  start(driver(with(rounded + R"(,{"name":"Auto","asked":"","is":"Off","state":"read","remark":""})"),
               with(rounded + R"(,{"name":"Auto","asked":"","is":"Once","state":"read","remark":""})")));
  until([this] { return told.find("Once") != std::string::npos; });
  STRCMP_CONTAINS("camera: Gain: 1 was asked for, the camera took 1.2 (in steps of .4)", told.c_str());
  STRCMP_CONTAINS("camera: Auto was Off and is Once", told.c_str());
  LONGS_EQUAL(told.find("Gain:"), told.rfind("Gain:"));  // once
  LONGS_EQUAL(2, camera->take_opened().size());
}

TEST(TetheredCameras, HandOverPhotographsOfTheirFolderAloneAndLossesWithTheirExposure) {
  start(driver(says(kOpened) + ";" +
                   says(R"({"event":"photograph","file":"../a.tif","number":4,"exposed_ns":5,"exposed_sd_ns":2,"packets_resent":1})") +
                   ";" + says(R"({"event":"lost","number":5,"exposed_ns":9,"exposed_sd_ns":2,"why":"3 packets"})"),
               "true"));
  std::vector<LostEvent> lost;
  until([&] {
    for (auto& event : camera->take_lost()) lost.push_back(event);
    return !lost.empty();
  });
  const auto photographs = camera->take_photographs();
  LONGS_EQUAL(1, photographs.size());
  CHECK_TRUE(photographs[0].file == folder.path() / "a.tif");
  LONGS_EQUAL(5, to_ns(photographs[0].exposed->instant));
  STRCMP_CONTAINS("1 packets of a.tif were lost and sent again", told.c_str());
  STRCMP_EQUAL("3 packets", lost[0].why.c_str());
}

TEST(TetheredCameras, ThatAreGoneAreToldAndReadyAgainWhenTheyAreBack) {
  const std::string gone = says(R"({"event":"gone","why":"it does not answer"})");
  start("#!/bin/bash\nread -r open; read -r check\n" + says(kOpened) + "\n" +
        says(R"({"event":"ready"})") + "\nread -r check\n" + gone + "\nread -r check\n" + says(kOpened) + "\nread -r end\n");
  ready();
  now += std::chrono::seconds{1};
  until([this] { return !camera->problem(now).empty(); });
  STRCMP_EQUAL("the camera is gone: it does not answer", camera->problem(now).c_str());
  now += std::chrono::seconds{1};
  ready();
  STRCMP_CONTAINS("Maker M1 S7 is back", told.c_str());
}

TEST(TetheredCameras, WhoseDriverEndsOrBabblesGetANewOne) {
  for (const char* end : {"exit 3", "kill -9 $$", "echo rubbish; sleep 100"}) {
    told.clear();
    start("#!/bin/bash\nif [ -e " + (folder / "again").string() + " ]; then\n" +
          driver(says(kOpened), says(R"({"event":"ready"})")).substr(12) + "exit\nfi\ntouch " + (folder / "again").string() + "\n" + end + "\n");
    until([this] { return told.find("the camera is gone: driver: ") != std::string::npos; });
    CHECK_FALSE(camera->problem(now).empty());
    now += std::chrono::seconds{2};
    ready();
    fs::remove(folder / "again");
  }
  STRCMP_CONTAINS("it said what is no event: no JSON object", told.c_str());
}

TEST(TetheredCameras, ADriverThatHangsGetsANewOne) {
  start("#!/bin/bash\nif [ -e " + (folder / "again").string() + " ]; then\n" +
        driver(says(kOpened), says(R"({"event":"ready"})")).substr(12) + "exit\nfi\ntouch " + (folder / "again").string() +
        "\nsleep 100\n");
  until([this] { return fs::exists(folder / "again"); });
  now += std::chrono::seconds{31};
  ready();
  STRCMP_CONTAINS("the camera is gone: its driver hangs", told.c_str());
}

TEST(TetheredCameras, ThatCannotBeOpenedAreTriedAgain) {
  start("#!/bin/bash\nread -r open; read -r check\n" + says(R"({"event":"failed","why":"no camera is there"})") +
        "\nread -r open; read -r check\n" + says(kOpened) + "\nread -r end\n");
  until([this] { return camera->problem(now) == "no camera is there"; });
  now += std::chrono::seconds{2};
  ready();
}

TEST(TetheredCameras, WithoutTheirDriverAreRefusedInWords) {
  const auto none = CameraDriver::find("abacus");
  CHECK_FALSE(none.has_value());
  STRCMP_CONTAINS("strobe-camera-abacus is not installed", none.error().message.c_str());
}
