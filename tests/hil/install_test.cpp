#include <string>

#include "tests/hil/rig_fixture.hpp"
#include "tests/support/private_network.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::hil;
using namespace std::chrono_literals;
using strobe::testing::ExitStatus;
using strobe::testing::run_process;

TEST_GROUP(Install) {
  strobe::testing::TemporaryFolder folder;
  const std::filesystem::path first = folder / "first";
  const std::filesystem::path moved = folder / "moved here";

  void setup() override {
    const auto installed = run_process(
        {{STROBE_CMAKE, "--install", STROBE_BUILD_DIR, "--prefix", first}, {}, {}, {}}, kLongestWait);
    CHECK_TEXT(installed.status == ExitStatus({0, 0}), installed.err.c_str());
    std::filesystem::rename(first, moved);
  }

  std::filesystem::path bin(const std::string& name) const { return moved / "bin" / name; }
};

TEST(Install, HasProgramsLibraryMessagesUnitRigScenesAndData) {
  for (const char* file : {"bin/strobed", "bin/strobe", "bin/strobe-sim", "share/strobe/rig.toml",
                           "share/strobe/boards/raspberry-pi-5.toml", "share/strobe/scenes/zero_23.toml",
                           "share/strobe/scenes/back_68.toml", "share/strobe/thesis/tables_02_to_10.csv",
                           "share/strobe/thesis/contact/zero_23.csv", "share/strobe/lcm/event_t.lcm",
                           "share/strobe/lcm/sealed_command_t.lcm", "lib/sysusers.d/strobe.conf",
                           "lib/udev/rules.d/60-strobe.rules", "share/polkit-1/rules.d/60-strobe.rules"})
    CHECK_TEXT(std::filesystem::exists(moved / file), file);
  bool library = false, unit = false;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(moved)) {
    library = library || entry.path().filename() == "libstrobe-gpiochip.so";
    unit = unit || entry.path().filename() == "strobed.service";
  }
  CHECK_TEXT(library, "no libstrobe-gpiochip.so");
  CHECK_TEXT(unit, "no strobed.service");
}

TEST(Install, NamesTheFolderThatItInstallsToInTheUnit) {
  std::string unit;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(moved))
    if (entry.path().filename() == "strobed.service") unit = strobe::testing::read_text(entry.path());
  const std::string program = (first / "bin/strobed").string();
  for (const char* key : {"ExecStart=", "ExecStopPost=", "ExecStartPre=-+"})
    CHECK_TEXT(unit.find("\n" + std::string(key) + program + " ") != std::string::npos, unit.c_str());
  CHECK_TEXT(unit.find("/usr/local") == std::string::npos, unit.c_str());
}

TEST(Install, RunsFromWhereItWasMoved) {
  const auto scenes = run_process({{bin("strobe-sim"), "scenes"}, {}, {}, {}}, 10s);
  CHECK_TEXT(scenes.status == ExitStatus({0, 0}), scenes.err.c_str());
  CHECK(scenes.out.find("zero_23") != std::string::npos);
  const auto predicted = run_process(
      {{bin("strobe"), "predict", "--vx", "15", "--vy", "-6", "--omega", "0", "--json"}, {}, {}, {}},
      kLongestWait);
  CHECK_TEXT(predicted.status == ExitStatus({0, 0}), predicted.err.c_str());
}

TEST(Install, FiresAShotFromWhereItWasMoved) {
  const std::string url = strobe::testing::private_lcm_url();
  const std::filesystem::path session = folder / "session";
  std::filesystem::create_directory(session);
  strobe::testing::Process sim(
      {{bin("strobe-sim"), "run", "--scene", "zero_23", "--seed", "3", "--lcm-url", url, "--", bin("strobed"),
        "--config", moved / "share/strobe/rig.toml", "--session", session, "--lcm-url", url, "--allow-no-rt"},
       {},
       {},
       {}},
      folder.path());
  CHECK_TEXT(sim.wait_for_err("strobed: ready", kLongestWait), sim.err().c_str());
  const auto fired = run_process({{bin("strobe"), "fire", "--shots", "1", "--retries", "0", "--session",
                                   session, "--lcm-url", url, "--json"},
                                  {},
                                  {},
                                  {}},
                                 60s);
  CHECK_TEXT(fired.status == ExitStatus({0, 0}), fired.err.c_str());
  CHECK(!readouts(fired.out).empty());
}
