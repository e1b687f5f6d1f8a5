// strobed --check on a bench that runs nothing: every item is there, once, in words.
#include <pthread.h>
#include <sched.h>

#include <algorithm>
#include <atomic>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "firmware/core/rig.hpp"
#include "sim/gpiochip/chip.hpp"
#include "tests/hil/line_changes.hpp"
#include "tests/support/json_lines.hpp"
#include "tests/support/private_network.hpp"
#include "tests/support/skip.hpp"

#include "tests/hil/expectations.hpp"
#include <CppUTest/TestHarness.h>

using namespace strobe::hil;
using namespace strobe::testing;
using namespace std::chrono_literals;

namespace {

RigFixtureOptions chip_with_nobody_on_it(const std::string& chip = "") {
  RigFixtureOptions options;
  options.scene_addition = chip;
  options.shell = "sleep 100";
  options.rig_edits = {{"cpu = -1", "cpu = 0"}};
  return options;
}

/// What --check says of the bias of key and e-stop, once the chip is there.
std::string biases_of_waiting(const RigFixture& bench) {
  const auto finished = run_process(
      bench.strobed({"--check", "--allow-no-rt", "--config", bench.rig_file(), "--lcm-url", bench.lcm_url()}),
      20s);
  std::string found;
  std::istringstream lines(finished.out);
  for (std::string line; std::getline(lines, line);)
    if (line.find(".bias") != std::string::npos) found += line + "\n";
  return found;
}

std::string biases_of(RigFixture& bench) {
  CHECK(bench.sim().wait_for_err("strobe-sim: scene", 20s));
  return biases_of_waiting(bench);
}

/// Of the kernel's drivers, by label.
const std::map<std::string, std::size_t> kLinesOfChip{
    {"pinctrl-bcm2835", 54}, {"pinctrl-bcm2711", 58}, {"pinctrl-rp1", 54}, {"cp2112_gpio", 8}};

strobe::sim::Chip chip_of(const std::filesystem::path& folder, const std::string& label) {
  strobe::sim::ChipSpec spec;
  spec.name = "gpiochip11";
  spec.label = label;
  spec.lines.resize(kLinesOfChip.at(label));
  auto chip = strobe::sim::Chip::create(folder, spec);
  CHECK_TEXT(chip.has_value(), chip ? "" : chip.error().message.c_str());
  return std::move(*chip);
}

std::string checked(const std::filesystem::path& rig, const std::filesystem::path& chip) {
  Command command;
  command.arguments = {program("strobed"), "--check", "--allow-no-rt", "--seconds", "0", "--config", rig};
  command.environment = strobe::hil::environment_of_chip(chip);
  return run_process(command, 20s).out;
}

}  // namespace

TEST_GROUP(Check) {
  TemporaryFolder folder;
  RigFixture bench{chip_with_nobody_on_it()};

  void setup() override { CHECK(bench.sim().wait_for_err("strobe-sim: scene", 20s)); }
  CompletedProcess check(const std::vector<std::string>& more) const {
    return check(bench, more);
  }
  static CompletedProcess check(const RigFixture& bench,
                                                 const std::vector<std::string>& more) {
    std::vector<std::string> words{"--check",        "--allow-no-rt", "--config",
                                   bench.rig_file(), "--lcm-url",     bench.lcm_url()};
    words.insert(words.end(), more.begin(), more.end());
    return run_process(bench.strobed(words), 20s);
  }
};

TEST_GROUP(CheckBias){};

TEST(CheckBias, TellsThatClosedContactsHoldTheirLines) {
  RigFixture bench{chip_with_nobody_on_it()};
  STRCMP_EQUAL(
      "lines.key.bias   ok: pull_down is set as far as the kernel tells; the closed contact holds the line\n"
      "lines.estop.bias ok: pull_down is set as far as the kernel tells; the closed contact holds the line\n",
      biases_of(bench).c_str());
  CHECK_FALSE(strobe::hil::LineWatcher(bench.chip_dir()).state("KEY").requested);
}

TEST(CheckBias, ProvesTheResistorWhereTheContactIsOpen) {
  RigFixture bench{chip_with_nobody_on_it("[chip]\nreset_pull = \"up\"\n")};
  CHECK(bench.sim().wait_for_err("strobe-sim: scene", 20s));
  bench.drive("KEY=open");
  STRCMP_CONTAINS(
      "lines.key.bias   ok: pull_down, and the line follows it: its contact or its wire is open now",
      biases_of_waiting(bench).c_str());
  LONGS_EQUAL(0, strobe::hil::LineWatcher(bench.chip_dir()).state("KEY").level);
}

TEST(CheckBias, AdvisesAResistorWhereTheChipHasNoneOrMayHaveNone) {
  RigFixture refusing{chip_with_nobody_on_it("[chip]\nbias = \"refused\"\n")};
  STRCMP_CONTAINS(
      "lines.key.bias   advice: the chip cannot set bias = \"pull_down\" (Invalid argument): a broken wire "
      "stops the rig only where a resistor on the line pulls it down",
      biases_of(refusing).c_str());
  RigFixture silent{chip_with_nobody_on_it("[chip]\nbias = \"ignored\"\nestop_level = 0\n")};
  STRCMP_CONTAINS(
      "lines.estop.bias advice: pull_down is set as far as the kernel tells, but the other pull does not "
      "move the line",
      biases_of(silent).c_str());
}

TEST(CheckBias, AdvisesAResistorWhereTheFileWantsNoBias) {
  RigFixtureOptions options = chip_with_nobody_on_it();
  options.rig_edits.push_back({"{ line = \"KEY\" }", "{ line = \"KEY\", bias = \"as_is\" }"});
  RigFixture bench{options};
  STRCMP_CONTAINS("lines.key.bias   advice: \"as_is\": a broken wire stops the rig only where a resistor",
                  biases_of(bench).c_str());
}

TEST(CheckBias, StartsOnAChipThatRefusesWithAWarningButNotAgainstTheFile) {
  RigFixtureOptions options;
  options.scene_addition = "[chip]\nbias = \"refused\"\n";
  {
    ReadyRig bench{options};
    STRCMP_CONTAINS("strobed: warning: ", bench.log().c_str());
    STRCMP_CONTAINS("lines.estop: the chip cannot set bias = \"pull_down\"", bench.log().c_str());
  }
  options.rig_edits.push_back({"{ line = \"KEY\" }", "{ line = \"KEY\", bias = \"pull_down\" }"});
  RigFixture refused{options};
  CHECK(refused.sim().wait(20s).has_value());
  STRCMP_CONTAINS(
      "lines.key: the chip cannot set bias = \"pull_down\" (Invalid argument): with a resistor on the line",
      refused.log().c_str());
}

TEST(Check, FindsEveryItemOfABenchThatIsReady) {
  const auto finished = check({"--json", "--session", folder / "session"});
  LONGS_EQUAL(0, finished.status ? finished.status->code : -1);
  std::map<std::string, nlohmann::json> items;
  for (const nlohmann::json& item : parse_json_lines(finished.out)) {
    CHECK_FALSE(items.contains(item["item"]));
    CHECK_TEXT(item["ok"] || item["tolerated"], item.dump().c_str());
    items[item["item"]] = item;
  }
  for (const char* name : {"rig file",     "chip.name",      "lines.strobe_a",
                           "lines.estop",  "lines.key.bias", "lines.estop.bias",
                           "policy",       "priority",       "memory",
                           "pinning",      "latency",        "tick",
                           "governor",     "throttling",     "isolation",
                           "preemption",   "interrupts",     "fixed_interrupts",
                           "clock_source", "kernel",         "session",
                           "lcm",          "machine"})
    CHECK_TEXT(items.contains(name), name);
}

TEST(Check, NamesWhatIsMissingAndFails) {
  const auto finished = check({});  // no folder for the journal
  LONGS_EQUAL(1, finished.status ? finished.status->code : -1);
  CHECK(finished.out.find("session          --session is required") != std::string::npos);
  CHECK(finished.out.find("chip.name        ok") != std::string::npos);
}

// The rig files of boards, each checked on a simulated chip with that board's label and lines.

TEST_GROUP(Boards) { TemporaryFolder folder; };

TEST(Boards, FindTheirChipAndEveryLineOfTheirRigFile) {
  for (const auto& entry : std::filesystem::directory_iterator(share("boards"))) {
    const auto rig = strobe::firmware::read_rig(read_text(entry.path()), entry.path());
    CHECK_TEXT(rig.has_value(), rig ? "" : rig.error().message.c_str());
    const strobe::sim::Chip chip = chip_of(folder / "chip", rig->chip);
    const std::string out = checked(entry.path(), chip.dir());
    STRCMP_CONTAINS("chip.name        ok: /dev/gpiochip11", out.c_str());
    for (std::size_t i = 1; i < strobe::firmware::kLineCount; ++i) {
      const auto which = static_cast<strobe::firmware::Line>(i);
      if (!rig->line(which).fitted) continue;
      std::string item = std::string("lines.") + strobe::firmware::line_key(which);
      item.resize(17, ' ');
      CHECK_TEXT(out.find(item + "ok") != std::string::npos, out.c_str());
    }
    CHECK_TEXT(out.find("lines.estop.bias ok: pull_down") != std::string::npos ||
                   out.find("lines.estop.bias advice: pull_down") != std::string::npos,
               out.c_str());
  }
}

TEST(Boards, AreToldApart) {
  const strobe::sim::Chip chip = chip_of(folder / "chip", "pinctrl-bcm2711");
  const std::string out = checked(share("boards") / "raspberry-pi-5.toml", chip.dir());
  STRCMP_CONTAINS("there is no chip \"pinctrl-rp1\"; there are ", out.c_str());
  STRCMP_CONTAINS("/dev/gpiochip11 (pinctrl-bcm2711)", out.c_str());
}

// As far as there is no Raspberry Pi 5 here.
TEST(Boards, OfARaspberryPi5SayThatItsPioIsNotThere) {
  if (std::filesystem::exists("/dev/pio0")) skip("there is a /dev/pio0 here");
  std::string text = read_text(share("boards") / "raspberry-pi-5.toml");
  const auto pio = text.find("#pio = ");
  CHECK(pio != text.npos);
  text.erase(pio, 1);
  const std::filesystem::path rig = folder / "rig.toml";
  std::ofstream(rig) << text;
  const strobe::sim::Chip chip = chip_of(folder / "chip", "pinctrl-rp1");
  const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(pio), '\n');
  const std::string words = rig.string() + ":" + std::to_string(line) + ": chip.pio: \"/dev/pio0\" is not there: ";
  STRCMP_CONTAINS(("chip.pio         " + words).c_str(), checked(rig, chip.dir()).c_str());

  Command command;
  command.arguments = {program("strobed"), "--allow-no-rt", "--config", rig, "--session", folder / "session"};
  command.environment = strobe::hil::environment_of_chip(chip.dir());
  command.environment["HOME"] = folder.path();
  const auto ended = run_process(command, 20s);
  LONGS_EQUAL(2, ended.status ? ended.status->code : -1);
  STRCMP_CONTAINS(("strobed: " + words).c_str(), ended.err.c_str());
}

// A machine made bad on purpose, in its own time. That a good one is called good is not judged, nor that nobody else is
// named: how this one is, nobody knows.

namespace {

/// Has a CPU for 5 ms in 100, as long as it is there.
class Hog {
 public:
  /// priority: of SCHED_FIFO.
  Hog(const char* name, int cpu, int priority) {
    thread_ = std::thread([=, this] {
      pthread_setname_np(pthread_self(), name);
      cpu_set_t set;
      CPU_ZERO(&set);
      CPU_SET(static_cast<std::size_t>(cpu), &set);
      sched_param wanted{};
      wanted.sched_priority = priority;
      granted_ = pthread_setaffinity_np(pthread_self(), sizeof set, &set) == 0 &&
                 pthread_setschedparam(pthread_self(), SCHED_FIFO, &wanted) == 0;
      started_ = true;
      while (!stop_) {
        const std::int64_t end = monotonic_now_ns() + 5'000'000;
        while (monotonic_now_ns() < end) {}
        sleep_for(95ms);
      }
    });
    while (!started_) sleep_for(1ms);
  }
  ~Hog() {
    stop_ = true;
    thread_.join();
  }
  bool granted() const { return granted_; }

 private:
  std::atomic<bool> started_ = false, granted_ = false, stop_ = false;
  std::thread thread_;
};

/// The lines about the machine, of two seconds' trial.
std::string tried(const std::filesystem::path& rig) {
  const auto finished =
      run_process({{program("strobed"), "--check", "--seconds", "2", "--config", rig}, {}, {}, {}}, 30s);
  CHECK_TEXT(finished.status.has_value(), finished.err.c_str());
  const std::size_t at = finished.out.find("\nheat ");
  CHECK_TEXT(at != std::string::npos, (finished.out + finished.err).c_str());
  return finished.out.substr(at);
}

}  // namespace

TEST_GROUP(MachineTrial) {
  TemporaryFolder folder;
  const std::filesystem::path rig = folder / "rig.toml";

  void setup() override {
    std::string text = read_text(share("rig.toml"));
    const std::string any = "cpu = -1";
    write_text(rig, text.replace(text.find(any), any.size(), "cpu = 0"));
  }
};

TEST(MachineTrial, NamesAThreadOfAHigherPriorityAndTheShotsThatItCosts) {
  const Hog hog("soundserver", 0, 90);
  if (!hog.granted()) return skip("no real-time priority is granted here");
  const std::string words = tried(rig);
  if (words.find("have no names") != std::string::npos) return skip("the kernel lets nobody watch its CPUs");
  STRCMP_CONTAINS(" shots would be aborted: ", words.substr(words.find("\nmachine ")).c_str());
  STRCMP_CONTAINS("soundserver (pid ", words.c_str());
  STRCMP_CONTAINS("its real-time priority, 90, is not below [real_time] priority (80)", words.c_str());
  STRCMP_CONTAINS("\nchrt -a -f -p 1 ", words.c_str());
}

TEST_GROUP(Install) {
  TemporaryFolder folder;
  const std::filesystem::path first = folder / "first";
  const std::filesystem::path moved = folder / "moved here";

  void setup() override {
    const auto installed = ran({{STROBE_CMAKE, "--install", STROBE_BUILD_DIR, "--prefix", first}, {}, {}, {}});
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
    if (entry.path().filename() == "strobed.service") unit = read_text(entry.path());
  const std::string program = (first / "bin/strobed").string();
  for (const char* key : {"ExecStart=", "ExecStopPost=", "ExecStartPre=-+"})
    CHECK_TEXT(unit.find("\n" + std::string(key) + program + " ") != std::string::npos, unit.c_str());
  CHECK_TEXT(unit.find("/usr/local") == std::string::npos, unit.c_str());
}

TEST(Install, RunsFromWhereItWasMoved) {
  const auto scenes = run_process({{bin("strobe-sim"), "scenes"}, {}, {}, {}}, 10s);
  CHECK_TEXT(scenes.status == ExitStatus({0, 0}), scenes.err.c_str());
  CHECK(scenes.out.find("zero_23") != std::string::npos);
  const auto predicted =
      ran({{bin("strobe"), "predict", "--vx", "15", "--vy", "-6", "--omega", "0", "--json"}, {}, {}, {}});
}

TEST(Install, FiresAShotFromWhereItWasMoved) {
  const std::string url = private_lcm_url();
  const std::filesystem::path session = folder / "session";
  std::filesystem::create_directory(session);
  Process sim(
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
