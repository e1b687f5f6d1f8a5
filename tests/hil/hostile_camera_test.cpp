// A device on the camera's network that means harm: neither strobe nor the series hangs or dies of it, and what is wrong
// is told.
#include <string>

#include "tests/hil/rig_fixture.hpp"
#include "tests/support/string_from.hpp"

#include "tests/hil/expectations.hpp"

using namespace strobe::hil;

TEST_GROUP(HostileCamera) {
  strobe::testing::CompletedProcess fired_with(const std::string& hostile, const std::string& more = "") {
    RigFixtureOptions options;
    options.rig_edits = kShortExposure;
    options.scene_addition = "[camera]\npx_per_m = 1500\norigin_x_px = 600\norigin_y_px = 150\n[camera_link]\nhostile = \"" +
                             hostile + "\"\n" + more;
    options.rig_edits.emplace_back("photograph_timeout_s = 5", "photograph_timeout_s = 2");
    options.rig_edits.emplace_back("\npx_per_m = 4000.0", "\npx_per_m = 1500\npx_per_m_sd = 0.5");
    options.rig_edits.emplace_back("[camera]\n", "[camera]\nkind = \"genicam\"\naddress = \"127.0.1.8\"\n");
    options.sim_options = {"--camera", "gev", "--camera-address", "127.0.1.8", "--time", "fast"};
    ReadyRig rig(options);
    return strobe::testing::run_process(rig.fire(1, 0, {"--wait", "10"}), kLongestWait);
  }
  /// Nothing counts, it ends by itself, and says so.
  void refuses(const std::string& hostile, const char* told) {
    const auto fired = fired_with(hostile);
    CHECK_TEXT(fired.status == strobe::testing::ExitStatus({1, 0}), fired.err.c_str());
    STRCMP_CONTAINS(told, fired.err.c_str());
    STRCMP_CONTAINS("0 of 1 shot counted", fired.err.c_str());
  }
};

TEST(HostileCamera, ADescriptionThatExplodesIsNotRead) { refuses("xml", "the camera is gone"); }

TEST(HostileCamera, FramesThatAreSaidToBeHugeAreNotTaken) { refuses("payload", "4294967280 bytes"); }

TEST(HostileCamera, AFrameThatIsNotOfItsStatedSizeIsNoPhotograph) { refuses("sizes", "bytes are too few for"); }

TEST(HostileCamera, AFrameWithoutAnEndIsCutWhereItShouldEnd) {
  const auto fired = fired_with("endless", "rate_mbps = 10\n");  // so that it takes no processor for minutes
  CHECK_TEXT(fired.status == strobe::testing::ExitStatus({0, 0}), fired.err.c_str());
  STRCMP_CONTAINS("1 of 1 shot counted", fired.err.c_str());
}
