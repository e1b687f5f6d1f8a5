// strobe commission on the simulated rig: a good one passes and is recorded, a bad one is named, an interrupted one is safe.
// A person's part is played by strobe-sim operator.
#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/support/json_lines.hpp"
#include "tests/support/process.hpp"

#include "tests/hil/expectations.hpp"
#include <CppUTest/TestHarness.h>

using namespace strobe::hil;
using namespace strobe::testing;
using namespace std::chrono_literals;

namespace {

Command commission(const RigFixture& bench, std::vector<std::string> more) {
  std::vector<std::string> words{
      "commission", "--yes", "--json", "--lcm-url", bench.lcm_url(), "--session", bench.folder() / "proof"};
  words.insert(words.end(), more.begin(), more.end());
  return bench.strobe(words);
}

/// With somebody at the rig who turns the key, presses the e-stop and pulls their wires when the console asks for it.
Command with_operator(const RigFixture& bench, Command command) {
  const std::vector<std::string> words{program("strobe-sim"), "operator", "--chip-dir", bench.chip_dir(), "--"};
  command.arguments.insert(command.arguments.begin(), words.begin(), words.end());
  return command;
}

nlohmann::json result_of(const std::string& out, const std::string& step) {
  for (const nlohmann::json& line : parse_json_lines(out))
    if (line.at("step") == step) return line;
  return {{"state", "not done"}, {"fault", "not done"}, {"words", out}};
}

}  // namespace

TEST_GROUP(Commission){};

TEST(Commission, AGoodRigPassesAndNothingIsProvenTwice) {
  RigFixtureOptions options;
  options.rig_edits = {{"#xsync = ", "xsync = "}};
  ReadyRig bench(options);
  bench.drive("KEY=0");
  bench.drive("ESTOP=0");
  const auto first = run_process(with_operator(bench, commission(bench, {})), kLongestWait);
  CHECK_TEXT(first.status == ExitStatus({0, 0}), (first.out + first.err).c_str());
  for (const char* const step : {"firmware", "key", "key_wire", "estop", "estop_wire", "lamp_a", "lamp_b",
                                 "lamps_together", "shutter", "trigger"})
    CHECK_EQUAL_TEXT(std::string("passed"), result_of(first.out, step).at("state").get<std::string>(), step);
  DOUBLES_EQUAL(45.0, result_of(first.out, "shutter").at("value").get<double>(), 1.0);
  const std::string record = read_text(bench.folder() / "rig.commission.jsonl");
  CHECK_EQUAL(record, read_text(bench.folder() / "proof" / "commission.jsonl"));

  const auto again = run_process(commission(bench, {}), kLongestWait);
  CHECK_EQUAL("not done", result_of(again.out, "lamp_a").at("state").get<std::string>());
  CHECK_TEXT(again.status == ExitStatus({0, 0}), again.err.c_str());
  CHECK_EQUAL(1, bench.finish().rises("TRIGGER"));
}

TEST(Commission, NamesSensorsThatAreSwapped) {
  RigFixtureOptions options;
  options.rig_edits = {{"sensor_a = { line = \"SENSOR_A\" }", "sensor_a = { line = \"SENSOR_X\" }"},
                       {"sensor_b = { line = \"SENSOR_B\" }", "sensor_b = { line = \"SENSOR_A\" }"},
                       {"SENSOR_X", "SENSOR_B"}};
  ReadyRig bench(options);
  const auto tried = ran(commission(bench, {"--only", "lamp_a"}), 1);
  CHECK_EQUAL("sensors_swapped", result_of(tried.out, "lamp_a").at("fault").get<std::string>());
}

TEST(Commission, NamesAKeyThatNobodyTurns) {
  ReadyRig bench;
  const auto tried = ran(commission(bench, {"--only", "key", "--wait", "2"}), 1);
  CHECK_EQUAL("stuck", result_of(tried.out, "key").at("fault").get<std::string>());
  CHECK_EQUAL(0, bench.finish().rises("STROBE_A"));
}

TEST(Commission, ThrowsNothingWhereKeyAndEStopAreNotProven) {
  ReadyRig bench;
  const auto tried = ran(commission(bench, {"--only", "trigger"}), 1);
  CHECK_EQUAL("failed", result_of(tried.out, "trigger").at("state").get<std::string>());
  CHECK_EQUAL(0, bench.finish().rises("TRIGGER"));
}

TEST(Commission, InterruptedItDisarmsAndKeepsWhatIsDone) {
  ReadyRig bench;
  const auto done = ran(commission(bench, {"--only", "firmware"}));
  Process lamps = bench.start(commission(bench, {"--from", "lamp_a"}));
  CHECK(lamps.wait_for_err("lamp_a: lamp A alone: 100 flashes", kLongestWait));
  lamps.signal(SIGINT);
  CHECK(lamps.wait(kLongestWait) == ExitStatus({1, 0}));
  CHECK(lamps.err().find("go on with: strobe commission") != std::string::npos);
  const std::string record = read_text(bench.folder() / "rig.commission.jsonl");
  CHECK_EQUAL(1, std::count(record.begin(), record.end(), '\n'));
  const auto changes = bench.finish();
  CHECK(changes.outputs_safe_from(0) != INT64_MAX);
}
