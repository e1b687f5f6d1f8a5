// Aravis, by its own tools, as the judge of the simulated camera: strobe-sim shares nothing with it.
#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/support/process.hpp"
#include "tests/support/temporary_folder.hpp"

#include "tests/support/string_from.hpp"

namespace {

using namespace std::chrono_literals;
using namespace strobe::testing;

constexpr const char* kAddress = "127.0.1.9";
constexpr auto kLimit = 120s;

/// A scene of few pixels, so that frames are soon rendered.
std::string small_scene(const std::string& link) {
  return "inherits = \"zero_23\"\n[camera]\npx_per_m = 500\norigin_x_px = 190\norigin_y_px = 40\n" + link;
}

}  // namespace

TEST_GROUP(Aravis) {
  TemporaryFolder folder;

  /// What the words say on a rig with that camera, in rig time.
  CompletedProcess on_rig(const std::string& link, std::vector<std::string> words) {
    write_text(folder / "scene.toml", small_scene(link));
    Command command;
    command.arguments = {std::string(STROBE_BUILD_DIR) + "/bin/strobe-sim", "run", "--scene",
                         folder / "scene.toml", "--no-digitizer", "--seed", "3", "--time", "fast", "--camera",
                         "gev", "--camera-address", kAddress, "--"};
    command.arguments.insert(command.arguments.end(), words.begin(), words.end());
    return run_process(command, kLimit);
  }
  CompletedProcess tool(std::vector<std::string> words) {
    words.insert(words.begin(), {"arv-tool-0.8", "--address", kAddress});
    return on_rig("", std::move(words));
  }
  /// As arv-camera-test counts it at its end.
  static long counted(const CompletedProcess& done, const std::string& name) {
    const std::size_t at = done.out.find(name);
    CHECK_TEXT(at != std::string::npos, (done.out + done.err).c_str());
    return std::stol(done.out.substr(done.out.find('=', at) + 1));
  }
  CompletedProcess capture(const std::string& link, std::vector<std::string> more = {}) {
    std::vector<std::string> words{"arv-camera-test-0.8", "-n",         kAddress,     "--duration=2",
                                   "--no-packet-socket",  "--features", "PixelFormat=Mono12 AcquisitionFrameRate=10"};
    words.insert(words.end(), more.begin(), more.end());
    return on_rig(link, std::move(words));
  }
};

TEST(Aravis, FindsTheCameraOnTheNetwork) {
  const CompletedProcess done = on_rig("", {"arv-tool-0.8"});
  STRCMP_CONTAINS("Strobe-SimulatedCamera-SIM-7F000109 (127.0.1.9)", done.out.c_str());
}

TEST(Aravis, ReadsEveryFeatureByItsName) {
  const CompletedProcess done = tool({"features"});
  for (const char* feature :
       {"DeviceSerialNumber", "DeviceTemperature", "TimestampLatchValue", "SensorWidth", "SensorHeight", "Width",
        "Height", "PixelFormat", "AcquisitionMode", "AcquisitionStart", "AcquisitionStop", "TriggerSelector",
        "TriggerMode", "TriggerSource", "TriggerActivation", "TriggerSoftware", "ExposureMode", "ExposureTime",
        "ExposureAuto", "Gain", "GainAuto", "BlackLevel", "Gamma", "GammaEnable", "BalanceWhiteAuto",
        "PayloadSize", "GevSCPSPacketSize"})
    STRCMP_CONTAINS(("'" + std::string(feature) + "'").c_str(), done.out.c_str());
}

TEST(Aravis, SetsFeaturesAndReadsThemBack) {
  const CompletedProcess done =
      tool({"control", "PixelFormat=BayerRG12", "ExposureMode=TriggerWidth", "ExposureTime=1236", "Gain=3",
            "GammaEnable=false", "TriggerMode=On", "DeviceUserID=side", "DeviceSerialNumber", "PayloadSize"});
  for (const char* line : {"PixelFormat = BayerRG12", "ExposureMode = TriggerWidth", "ExposureTime = 1240 us",
                           "Gain = 3 dB", "GammaEnable = false", "TriggerMode = On", "DeviceUserID = side",
                           "DeviceSerialNumber = SIM-7F000109"})
    STRCMP_CONTAINS(line, done.out.c_str());
}

TEST(Aravis, ReceivesEveryFrame) {
  const CompletedProcess done = capture("");
  CHECK_TEXT(counted(done, "n_completed_buffers") >= 15, done.out.c_str());
  LONGS_EQUAL(0, counted(done, "n_failures"));
  LONGS_EQUAL(0, counted(done, "n_missing_packets"));
  LONGS_EQUAL(0, counted(done, "n_size_mismatch_errors"));
}

TEST(Aravis, AsksAgainForPacketsThatAreLost) {
  const CompletedProcess done = capture("[camera_link]\nloss = 0.02\n");
  CHECK_TEXT(counted(done, "n_completed_buffers") >= 15, done.out.c_str());
  CHECK_TEXT(counted(done, "n_resent_packets") > 0, done.out.c_str());
  LONGS_EQUAL(0, counted(done, "n_missing_packets"));
}

TEST(Aravis, FindsThatLargePacketsPassByATestPacket) {
  const CompletedProcess done = capture("", {"-i", "8000", "-j", "always"});
  LONGS_EQUAL(0, counted(done, "n_failures"));
  // Leader, trailer and what 7964 bytes hold each: else Aravis would have gone down to smaller ones.
  const long payload = counted(done, "payload "), frames = counted(done, "n_completed_buffers");
  const long each = (payload + 7963) / 7964 + 2;
  CHECK_TEXT(counted(done, "n_received_packets") < (frames + 2) * each, done.out.c_str());
}

TEST(Aravis, RefusesADescriptionThatExplodes) {
  const CompletedProcess done = on_rig("[camera_link]\nhostile = \"xml\"\n",
                                       {"arv-tool-0.8", "--address", kAddress, "control", "Width"});
  CHECK_TRUE(done.out.find("Width =") == std::string::npos);
}
