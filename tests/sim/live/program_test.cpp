#include <algorithm>
#include <csignal>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/support/gpio_tools.hpp"
#include "tests/support/json_lines.hpp"
#include "tests/support/process.hpp"
#include "tests/support/temporary_folder.hpp"

#include "tests/support/string_from.hpp"

namespace {

using namespace std::chrono_literals;
using namespace strobe::testing;

const std::string kSim = std::string(STROBE_BUILD_DIR) + "/bin/strobe-sim";
constexpr auto kLimit = 20s;

Command sim(std::vector<std::string> words) {
  words.insert(words.begin(), kSim);
  Command command;
  command.arguments = std::move(words);
  return command;
}

Command on_rig(std::vector<std::string> options, const std::vector<std::string>& command) {
  std::vector<std::string> words{"run", "--scene", "zero_23", "--no-digitizer", "--seed", "42"};
  words.insert(words.end(), options.begin(), options.end());
  words.push_back("--");
  words.insert(words.end(), command.begin(), command.end());
  return sim(words);
}

}  // namespace

TEST_GROUP(SimProgram) {
  strobe::testing::TemporaryFolder folder;

  /// Exit status 2 and one line on standard error with that word.
  void check_refused(const Command& command, const char* word) {
    const CompletedProcess finished = strobe::testing::run_process(command, kLimit);
    CHECK_TEXT(finished.status == ExitStatus({2, 0}), finished.err.c_str());
    LONGS_EQUAL(1, std::count(finished.err.begin(), finished.err.end(), '\n'));
    STRCMP_CONTAINS(word, finished.err.c_str());
  }
};

TEST(SimProgram, PassesTheCommandsExitStatusOn) {
  const CompletedProcess finished = strobe::testing::run_process(on_rig({}, {"sh", "-c", "exit 7"}), kLimit);
  CHECK_EQUAL(ExitStatus({7, 0}), finished.status);
  STRCMP_CONTAINS("strobe-sim: scene zero_23, seed 42 (repeat with --seed 42), chip /dev/gpiochip0 in ",
                  finished.err.c_str());
}

TEST(SimProgram, AddsTheSignalTo128) {
  const CompletedProcess finished =
      strobe::testing::run_process(on_rig({}, {"sh", "-c", "kill -KILL $$"}), kLimit);
  CHECK_EQUAL(ExitStatus({128 + SIGKILL, 0}), finished.status);
}

TEST(SimProgram, ForwardsSignalsAndWaitsForTheCommandsOwnEnd) {
  for (const auto& [signal, word] : {std::pair{SIGTERM, "TERM"}, std::pair{SIGINT, "INT"}}) {
    const std::string script =
        std::string("trap 'exit 9' ") + word + "; echo up; while :; do sleep 0.01; done";
    Process process(on_rig({}, {"sh", "-c", script}), folder.path());
    CHECK(process.wait_for_out("up", kLimit));
    process.signal(signal);
    CHECK_EQUAL(ExitStatus({9, 0}), process.wait(kLimit));
  }
}

TEST(SimProgram, PutsItsLibraryFirstAndKeepsTheRestOfTheEnvironment) {
  Command command = on_rig({}, {"sh", "-c", "echo $LD_PRELOAD $STROBE_GPIOCHIP_DIR $KEPT"});
  command.environment = {{"LD_PRELOAD", "libm.so.6"}, {"KEPT", "kept"}};
  const CompletedProcess finished = strobe::testing::run_process(command, kLimit);
  STRCMP_CONTAINS("/libstrobe-gpiochip.so:libm.so.6 /", finished.out.c_str());
  STRCMP_CONTAINS(" kept\n", finished.out.c_str());
}

TEST(SimProgram, LeavesNoFolderBehind) {
  const CompletedProcess finished =
      strobe::testing::run_process(on_rig({}, {"sh", "-c", "printf %s $STROBE_GPIOCHIP_DIR"}), kLimit);
  CHECK(!finished.out.empty());
  CHECK(!std::filesystem::exists(finished.out));
}

TEST(SimProgram, RefusesWhatItCannotDoInOneLine) {
  check_refused(sim({"run", "--scene", "zero_99", "--", "true"}), "zero_99");
  check_refused(sim({"run", "--scene", folder / "none.toml", "--", "true"}), "none.toml");
  check_refused(sim({"run", "--", "true"}), "--scene");
  check_refused(sim({"run", "--scene", "zero_23"}), "command");
  check_refused(sim({"run", "--scene", "zero_23", "--rig", "a/b", "--", "true"}), "a/b");
  check_refused(on_rig({"--truth", folder / "no/truth.jsonl"}, {"true"}), "truth.jsonl");
  check_refused(on_rig({"--changes", folder / "no/changes.csv"}, {"true"}), "changes.csv");
  check_refused(sim({"lines", "--chip-dir", folder / "none"}), "none");
  check_refused(sim({"dance"}), "dance");
  strobe::testing::write_text(folder / "wrong.toml", "[machine]\nspeed_mps = \"fast\"\n");
  check_refused(sim({"run", "--scene", folder / "wrong.toml", "--", "true"}),
                "wrong.toml:2: machine.speed_mps");
}

TEST(SimProgram, NamesACommandThatIsNotThere) {
  const CompletedProcess finished = strobe::testing::run_process(on_rig({}, {"/nowhere/strobed"}), kLimit);
  CHECK_EQUAL(ExitStatus({2, 0}), finished.status);
  STRCMP_CONTAINS("/nowhere/strobed: No such file", finished.err.c_str());
}

TEST(SimProgram, ShowsAndDrivesLinesOfARunningChip) {
  const std::string chip = folder / "chip";
  const std::string script = kSim + " lines --json --chip-dir " + chip + "; " + kSim + " drive --chip-dir " +
                             chip + " KEY=0 8=0; " + kSim + " lines --json --chip-dir " + chip;
  const CompletedProcess finished = strobe::testing::run_process(
      on_rig({"--chip-dir", chip, "--changes", folder / "changes.csv"}, {"sh", "-c", script}), kLimit);
  CHECK_TEXT(finished.status == ExitStatus({0, 0}), finished.err.c_str());
  const auto lines = strobe::testing::parse_json_lines(finished.out);
  LONGS_EQUAL(32, lines.size());
  CHECK_EQUAL("STROBE_A", lines[0]["name"].get<std::string>());
  CHECK_EQUAL("input", lines[0]["direction"].get<std::string>());
  LONGS_EQUAL(1, lines[7]["level"].get<int>());
  LONGS_EQUAL(1, lines[8]["level"].get<int>());
  LONGS_EQUAL(0, lines[16 + 7]["level"].get<int>());
  LONGS_EQUAL(0, lines[16 + 8]["level"].get<int>());

  const auto changes = strobe::testing::read_csv(folder / "changes.csv");
  LONGS_EQUAL(2, changes.rows.size());
  CHECK_EQUAL("KEY", changes.rows[0][changes.column("name")]);
  CHECK_EQUAL("0", changes.rows[0][changes.column("level")]);
  CHECK_EQUAL("drive", changes.rows[1][changes.column("cause")]);
  CHECK(!std::filesystem::exists(chip) || std::filesystem::is_empty(chip));
}

TEST(SimProgram, UnplugsTheChipInTheMiddleOfATrain) {
  // Lines held: edges that somebody waits for hang up, and the next pulse meets no device.
  const std::string chip = folder / "chip";
  const bool v2 = strobe::testing::gpio_tools_are_of_version_2();
  const std::string watch = v2 ? "gpiomon -c gpiochip0 6" : "gpiomon gpiochip0 6";
  const std::string set = v2 ? "gpioset -t0 -c gpiochip0 " : "gpioset gpiochip0 ";
  const std::string script = watch + " & " + kSim + " unplug --chip-dir " + chip +
                             " --after STROBE_A=2 & until " + kSim + " lines --chip-dir " + chip +
                             " | grep -q gpiomon; do :; done; for i in 1 2 3 4 5 6; do " + set + "0=1; " +
                             set + "0=0; sleep 0.2; done; wait";
  const CompletedProcess finished = strobe::testing::run_process(
      on_rig({"--chip-dir", chip, "--changes", folder / "changes.csv"}, {"sh", "-c", script}), kLimit);
  CHECK_TRUE(finished.status.has_value());
  STRCMP_CONTAINS("gpiomon: error ", finished.err.c_str());
  STRCMP_CONTAINS("No such device", finished.err.c_str());
  STRCMP_CONTAINS("gpioset: ", finished.err.c_str());
}

TEST(SimProgram, DrivesALineOnceAnotherHasRisenSoOften) {
  const std::string chip = folder / "chip";
  const std::string drive = kSim + " drive --chip-dir " + chip;
  // Pulses on a line that nobody holds, until the other command has seen its third and ended.
  const std::string script = drive + " --after GATE=3 KEY=0 & until ! kill -0 $! 2>/dev/null; do " + drive +
                             " GATE=1; " + drive + " GATE=0; done; wait $!";
  const CompletedProcess finished = strobe::testing::run_process(
      on_rig({"--chip-dir", chip, "--changes", folder / "changes.csv"}, {"sh", "-c", script}), kLimit);
  CHECK_TEXT(finished.status == ExitStatus({0, 0}), finished.err.c_str());
  const auto changes = strobe::testing::read_csv(folder / "changes.csv");
  int rises = 0;
  bool driven = false;
  for (const auto& row : changes.rows) {
    if (driven) break;
    rises += row[changes.column("name")] == "GATE" && row[changes.column("level")] == "1" ? 1 : 0;
    driven = row[changes.column("name")] == "KEY";
  }
  CHECK(driven);
  CHECK(rises >= 3);  // more rise before the command is under way
}

TEST(SimProgram, RefusesToUnplugWhatIsNoChipOrAfterWhatIsNoLine) {
  check_refused(sim({"unplug", "--chip-dir", folder / "none"}), "none");
  const std::string chip = folder / "chip";
  for (const char* after : {"STROBE=2", "STROBE_A", "STROBE_A=0", "99=1"}) {
    const CompletedProcess finished = strobe::testing::run_process(
        on_rig({"--chip-dir", chip}, {kSim, "unplug", "--chip-dir", chip, "--after", after}), kLimit);
    LONGS_EQUAL(2, finished.status.value().code);
    STRCMP_CONTAINS(after, finished.err.c_str());
    const CompletedProcess driven = strobe::testing::run_process(
        on_rig({"--chip-dir", chip}, {kSim, "drive", "--chip-dir", chip, "--after", after, "KEY=0"}), kLimit);
    LONGS_EQUAL(2, driven.status.value().code);
    STRCMP_CONTAINS(after, driven.err.c_str());
  }
}

TEST(SimProgram, RefusesToDriveWhatIsNoLine) {
  const std::string chip = folder / "chip";
  for (const char* drive : {"KEYS=0", "KEY", "KEY=2", "99=1", "=1", "KEYS=open", "KEY=opened"}) {
    const CompletedProcess finished = strobe::testing::run_process(
        on_rig({"--chip-dir", chip}, {kSim, "drive", "--chip-dir", chip, drive}), kLimit);
    CHECK_TEXT(finished.status == ExitStatus({2, 0}), drive);
    STRCMP_CONTAINS(drive, finished.err.c_str());
  }
}

TEST(SimProgram, PlaysTheOperatorInRealTime) {
  std::string scene = strobe::testing::read_text(std::string(STROBE_SCENES_FOLDER) + "/zero_23.toml");
  scene += "\n[[operator]]\nat_s = 0.3\nline = \"ESTOP\"\nlevel = 0\n";
  strobe::testing::write_text(folder / "stop.toml", scene);
  const CompletedProcess finished =
      strobe::testing::run_process(sim({"run", "--scene", folder / "stop.toml", "--no-digitizer", "--changes",
                                        folder / "changes.csv", "--", "sleep", "0.6"}),
                                   kLimit);
  CHECK_EQUAL(ExitStatus({0, 0}), finished.status);
  const auto changes = strobe::testing::read_csv(folder / "changes.csv");
  LONGS_EQUAL(1, changes.rows.size());
  CHECK_EQUAL("ESTOP", changes.rows[0][changes.column("name")]);
}

TEST(SimProgram, ListsTheScenes) {
  const CompletedProcess finished = strobe::testing::run_process(sim({"scenes", "--json"}), kLimit);
  CHECK_EQUAL(ExitStatus({0, 0}), finished.status);
  const auto scenes = strobe::testing::parse_json_lines(finished.out);
  CHECK_EQUAL("axis_tilted_10", scenes[0]["scene"].get<std::string>());
  std::size_t of_the_thesis = 0;
  for (const auto& scene : scenes) {
    const std::string name = scene["scene"];
    if (name.starts_with("zero_") || name.starts_with("top_") || name.starts_with("back_")) ++of_the_thesis;
    CHECK(scene["stiffness_npm"].get<double>() > 0.0);
    if (name == "drop_100in_low") CHECK_EQUAL("drop_100in", scene["inherits"].get<std::string>());
    if (name == "zero_23") CHECK(scene["inherits"].is_null());
  }
  LONGS_EQUAL(21, of_the_thesis);
}

TEST(SimProgram, TellsBrokenScenesAndListsTheOthers) {
  std::filesystem::create_directories(folder / "scenes");
  strobe::testing::write_text(folder / "scenes" / "good.toml",
                              "[machine]\nspeed_mps = 9\nangle_deg = -20\nspin_radps = 0\n"
                              "[bounce]\ne = 0.8\nmu = 0.6\ndwell_ms = 5\n");
  strobe::testing::write_text(folder / "scenes" / "bad.toml", "inherits = \"good\"\n[bounce]\nex = 0.1\n");
  Command command = sim({"scenes"});
  command.environment["STROBE_SHARE"] = folder / "";
  const CompletedProcess finished = strobe::testing::run_process(command, kLimit);
  CHECK_EQUAL(ExitStatus({1, 0}), finished.status);
  STRCMP_CONTAINS("bad                    broken", finished.out.c_str());
  STRCMP_CONTAINS("good ", finished.out.c_str());
  STRCMP_CONTAINS("bad.toml:3: bounce.ex: belongs to contact = \"grip\"", finished.err.c_str());
}

TEST(SimProgram, ReadsAParentByPathOrByName) {
  std::filesystem::create_directories(folder / "sub");
  strobe::testing::write_text(folder / "base.toml", "inherits = \"zero_23\"\n");
  strobe::testing::write_text(folder / "sub" / "child.toml",
                              "inherits = \"../base.toml\"\n[lamps]\ndelay_us = -1\n");
  check_refused(sim({"run", "--scene", folder / "sub" / "child.toml", "--", "true"}),
                "child.toml:3: lamps.delay_us");
  strobe::testing::write_text(folder / "base.toml", "inherits = \"sub/child.toml\"\n");
  check_refused(sim({"run", "--scene", folder / "sub" / "child.toml", "--", "true"}),
                "base.toml:1: inherits: ");
}

TEST(SimProgram, HelpsWithAnExample) {
  for (const char* command : {"run", "scenes", "lines", "drive", "fit"}) {
    const CompletedProcess finished = strobe::testing::run_process(sim({command, "--help"}), kLimit);
    CHECK_EQUAL(ExitStatus({0, 0}), finished.status);
    STRCMP_CONTAINS("Example: strobe-sim ", finished.out.c_str());
  }
}
