// strobe commission on the simulated rig: a good one passes and is recorded, a bad one is named, an interrupted one is safe.
// A person's part is played by whoever reads what the console asks for.
#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "tests/hil/expect_ready.hpp"
#include "tests/hil/rig_fixture.hpp"
#include "tests/support/json_lines.hpp"
#include "tests/support/process.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::hil;
using namespace std::chrono_literals;
using strobe::testing::ExitStatus;
using strobe::testing::Process;

namespace {

/// What is asked for, and how it shows on the chip's lines. The key's wire and the e-stop's have one answer each.
const std::vector<std::pair<std::string, std::string>> kActs{
    {"key: have the key off", "KEY=0"},
    {"key: turn the key on", "KEY=1"},
    {"key: turn the key off", "KEY=0"},
    {"key_wire: turn the key on", "KEY=1"},
    {"key_wire: pull the wire", "KEY=open"},
    {"key_wire: put the wire back", "KEY=1"},
    {"estop: have the e-stop pressed", "ESTOP=0"},
    {"estop: release the e-stop", "ESTOP=1"},
    {"estop: press the e-stop", "ESTOP=0"},
    {"estop_wire: release the e-stop", "ESTOP=1"},
    {"estop_wire: pull the wire", "ESTOP=open"},
    {"estop_wire: put the wire back", "ESTOP=1"},
};

/// Does what the console asks for, until the program ends.
void obey(const RigFixture& bench, Process& commission) {
  std::size_t read = 0;
  while (commission.running()) {
    const std::string said = commission.err();
    for (std::size_t end = said.find('\n', read); end != std::string::npos; end = said.find('\n', read)) {
      const std::string line = said.substr(read, end - read);
      read = end + 1;
      for (const auto& [words, drive] : kActs)
        if (line.find(words) != std::string::npos) bench.drive(drive);
    }
    std::this_thread::sleep_for(20ms);
  }
}

strobe::testing::Command commission(const RigFixture& bench, std::vector<std::string> more) {
  std::vector<std::string> words{
      "commission", "--yes", "--json", "--lcm-url", bench.lcm_url(), "--session", bench.folder() / "proof"};
  words.insert(words.end(), more.begin(), more.end());
  return bench.strobe(words);
}

nlohmann::json result_of(const std::string& out, const std::string& step) {
  for (const nlohmann::json& line : strobe::testing::parse_json_lines(out))
    if (line.at("step") == step) return line;
  return {{"state", "not done"}, {"fault", "not done"}, {"words", out}};
}

}  // namespace

TEST_GROUP(Commission){};

TEST(Commission, AGoodRigPassesAndNothingIsProvenTwice) {
  RigFixtureOptions options;
  options.rig_edits = {{"#xsync = ", "xsync = "}};
  RigFixture bench(options);
  expect_ready(bench);
  bench.drive("KEY=0");
  bench.drive("ESTOP=0");
  Process first = bench.start(commission(bench, {}));
  obey(bench, first);
  const std::string out = first.out(), err = first.err();
  CHECK_TEXT(first.wait(kLongestWait) == ExitStatus({0, 0}), (out + err).c_str());
  for (const char* const step : {"firmware", "key", "key_wire", "estop", "estop_wire", "lamp_a", "lamp_b",
                                 "lamps_together", "shutter", "trigger"})
    CHECK_EQUAL_TEXT(std::string("passed"), result_of(out, step).at("state").get<std::string>(), step);
  DOUBLES_EQUAL(45.0, result_of(out, "shutter").at("value").get<double>(), 1.0);
  const std::string record = strobe::testing::read_text(bench.folder() / "rig.commission.jsonl");
  CHECK_EQUAL(record, strobe::testing::read_text(bench.folder() / "proof" / "commission.jsonl"));

  const auto again = strobe::testing::run_process(commission(bench, {}), kLongestWait);
  CHECK_EQUAL("not done", result_of(again.out, "lamp_a").at("state").get<std::string>());
  CHECK_TEXT(again.status == ExitStatus({0, 0}), again.err.c_str());
  CHECK_EQUAL(1, bench.finish().rises("TRIGGER"));
}

TEST(Commission, NamesSensorsThatAreSwapped) {
  RigFixtureOptions options;
  options.rig_edits = {{"sensor_a = { line = \"SENSOR_A\" }", "sensor_a = { line = \"SENSOR_X\" }"},
                       {"sensor_b = { line = \"SENSOR_B\" }", "sensor_b = { line = \"SENSOR_A\" }"},
                       {"SENSOR_X", "SENSOR_B"}};
  RigFixture bench(options);
  expect_ready(bench);
  const auto tried = strobe::testing::run_process(commission(bench, {"--only", "lamp_a"}), kLongestWait);
  CHECK_TEXT(tried.status == ExitStatus({1, 0}), tried.err.c_str());
  CHECK_EQUAL("sensors_swapped", result_of(tried.out, "lamp_a").at("fault").get<std::string>());
}

TEST(Commission, NamesAKeyThatNobodyTurns) {
  RigFixture bench;
  expect_ready(bench);
  const auto tried =
      strobe::testing::run_process(commission(bench, {"--only", "key", "--wait", "2"}), kLongestWait);
  CHECK_TEXT(tried.status == ExitStatus({1, 0}), tried.err.c_str());
  CHECK_EQUAL("stuck", result_of(tried.out, "key").at("fault").get<std::string>());
  CHECK_EQUAL(0, bench.finish().rises("STROBE_A"));
}

TEST(Commission, ThrowsNothingWhereKeyAndEStopAreNotProven) {
  RigFixture bench;
  expect_ready(bench);
  const auto tried = strobe::testing::run_process(commission(bench, {"--only", "trigger"}), kLongestWait);
  CHECK_TEXT(tried.status == ExitStatus({1, 0}), tried.err.c_str());
  CHECK_EQUAL("failed", result_of(tried.out, "trigger").at("state").get<std::string>());
  CHECK_EQUAL(0, bench.finish().rises("TRIGGER"));
}

TEST(Commission, InterruptedItDisarmsAndKeepsWhatIsDone) {
  RigFixture bench;
  expect_ready(bench);
  const auto done = strobe::testing::run_process(commission(bench, {"--only", "firmware"}), kLongestWait);
  CHECK_TEXT(done.status == ExitStatus({0, 0}), done.err.c_str());
  Process lamps = bench.start(commission(bench, {"--from", "lamp_a"}));
  CHECK(lamps.wait_for_err("lamp_a: lamp A alone: 100 flashes", kLongestWait));
  lamps.signal(SIGINT);
  CHECK(lamps.wait(kLongestWait) == ExitStatus({1, 0}));
  CHECK(lamps.err().find("go on with: strobe commission") != std::string::npos);
  const std::string record = strobe::testing::read_text(bench.folder() / "rig.commission.jsonl");
  CHECK_EQUAL(1, std::count(record.begin(), record.end(), '\n'));
  const auto changes = bench.finish();
  CHECK(changes.outputs_safe_from(0) != INT64_MAX);
}
