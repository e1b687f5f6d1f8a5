// strobed --check on a bench that runs nothing: every item is there, once, in words.
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "tests/hil/expect_ready.hpp"
#include "tests/hil/line_watcher.hpp"
#include "tests/hil/rig_fixture.hpp"
#include "tests/support/json_lines.hpp"
#include "tests/support/private_network.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::hil;
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
  const auto finished = strobe::testing::run_process(
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

}  // namespace

TEST_GROUP(Check) {
  strobe::testing::TemporaryFolder folder;
  RigFixture bench{chip_with_nobody_on_it()};

  void setup() override { CHECK(bench.sim().wait_for_err("strobe-sim: scene", 20s)); }
  strobe::testing::CompletedProcess check(const std::vector<std::string>& more) const {
    return check(bench, more);
  }
  static strobe::testing::CompletedProcess check(const RigFixture& bench,
                                                 const std::vector<std::string>& more) {
    std::vector<std::string> words{"--check",        "--allow-no-rt", "--config",
                                   bench.rig_file(), "--lcm-url",     bench.lcm_url()};
    words.insert(words.end(), more.begin(), more.end());
    return strobe::testing::run_process(bench.strobed(words), 20s);
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
    RigFixture bench{options};
    expect_ready(bench);
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
  for (const nlohmann::json& item : strobe::testing::parse_json_lines(finished.out)) {
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
                           "clock_source", "session",        "lcm"})
    CHECK_TEXT(items.contains(name), name);
}

TEST(Check, NamesWhatIsMissingAndFails) {
  const auto finished = check({});  // no folder for the journal
  LONGS_EQUAL(1, finished.status ? finished.status->code : -1);
  CHECK(finished.out.find("session          no --session given") != std::string::npos);
  CHECK(finished.out.find("chip.name        ok") != std::string::npos);
}
