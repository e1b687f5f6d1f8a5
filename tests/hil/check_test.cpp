// strobed --check on a bench that runs nothing: every item is there, once, in words.
#include <map>
#include <string>
#include <vector>

#include "tests/hil/rig_fixture.hpp"
#include "tests/support/json_lines.hpp"
#include "tests/support/private_network.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::hil;
using namespace std::chrono_literals;

namespace {

RigFixtureOptions chip_with_nobody_on_it() {
  RigFixtureOptions options;
  options.shell = "sleep 100";
  options.rig_edits = {{"cpu = -1", "cpu = 0"}};
  return options;
}

}  // namespace

TEST_GROUP(Check) {
  strobe::testing::TemporaryFolder folder;
  RigFixture bench{chip_with_nobody_on_it()};

  void setup() override { CHECK(bench.sim().wait_for_err("strobe-sim: scene", 20s)); }
  strobe::testing::CompletedProcess check(const std::vector<std::string>& more) const {
    std::vector<std::string> words{"--check",        "--allow-no-rt", "--config",
                                   bench.rig_file(), "--lcm-url",     bench.lcm_url()};
    words.insert(words.end(), more.begin(), more.end());
    return strobe::testing::run_process(bench.strobed(words), 20s);
  }
};

TEST(Check, FindsEveryItemOfABenchThatIsReady) {
  const auto finished = check({"--json", "--session", folder / "session"});
  LONGS_EQUAL(0, finished.status ? finished.status->code : -1);
  std::map<std::string, nlohmann::json> items;
  for (const nlohmann::json& item : strobe::testing::parse_json_lines(finished.out)) {
    CHECK_FALSE(items.contains(item["item"]));
    CHECK_TEXT(item["ok"] || item["tolerated"], item.dump().c_str());
    items[item["item"]] = item;
  }
  for (const char* name : {"rig file", "chip.name", "lines.strobe_a", "lines.estop", "policy", "priority",
                           "memory", "pinning", "latency", "tick", "governor", "throttling", "isolation",
                           "preemption", "interrupts", "fixed_interrupts", "clock_source", "session", "lcm"})
    CHECK_TEXT(items.contains(name), name);
}

TEST(Check, NamesWhatIsMissingAndFails) {
  const auto finished = check({});  // no folder for the journal
  LONGS_EQUAL(1, finished.status ? finished.status->code : -1);
  CHECK(finished.out.find("session          no --session given") != std::string::npos);
  CHECK(finished.out.find("chip.name        ok") != std::string::npos);
}
