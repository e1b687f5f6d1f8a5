// Test protocols from the first ball to the verdict, by the shipped programs on the simulated rig, with photographs. What is
// right comes from the scene: its restitution and friction lie far within the limits, or far beyond.
#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tests/hil/rig_fixture.hpp"
#include "tests/support/string_from.hpp"

#include "tests/hil/expectations.hpp"

using namespace strobe::hil;
using nlohmann::json;
using strobe::testing::CompletedProcess;
using strobe::testing::ExitStatus;
using strobe::testing::run_process;

namespace {

struct Case {
  std::string protocol, scene, outcome;
  std::vector<std::string> notes{};
  std::vector<std::pair<std::string, std::string>> scene_edits{};
};

strobe::testing::Command fire_by(const RigFixture& bench, const Case& c, const std::vector<std::string>& more) {
  std::vector<std::string> words{"fire", "--session", bench.session(), "--no-pause", "--plain"};
  for (const std::string& note : c.notes) words.insert(words.end(), {"--note", note});
  words.insert(words.end(), more.begin(), more.end());
  return bench.strobe(std::move(words));
}

json verdict_of(const RigFixture& bench) {
  const CompletedProcess told = run_process(bench.strobe({"protocol", "verdict", bench.session(), "--json"}), kLongestWait);
  CHECK_TEXT(!told.out.empty(), told.err.c_str());
  return json::parse(told.out);
}

RigFixtureOptions rig_of(const Case& c) {
  RigFixtureOptions options;
  options.scene = c.scene;
  options.scene_edits = c.scene_edits;
  options.scene_rig = true;
  options.sim_options = kFastTime;
  return options;
}

long count_of(const json& verdict, const std::string& use) {
  const json& shots = verdict.at("shots");
  return std::count_if(shots.begin(), shots.end(), [&](const json& shot) { return shot.at("use") == use; });
}

const Case kCourtPace{"itf-court-pace", "itf_pace_medium", "pass", {"temperature_c=23"}};

}  // namespace

TEST_GROUP(TestProtocol) {
  void runs(const Case& c) {
    ReadyRig bench(rig_of(c));
    const CompletedProcess fired = run_process(fire_by(bench, c, {"--protocol", c.protocol}), kLongestWait);
    const json verdict = verdict_of(bench);
    const std::string told = fmt::format("{}\n{}\n{}", fired.err, fired.out, verdict.dump(1));
    CHECK_TRUE_TEXT(verdict.at("left").empty(), told.c_str());
    CHECK_EQUAL_TEXT(c.outcome, verdict.at("outcome").get<std::string>(), told.c_str());
    CHECK_TRUE(fired.status == ExitStatus({c.outcome == "pass" ? 0 : 1, 0}));
  }
};

TEST(TestProtocol, ClassifiesACourt) { runs(kCourtPace); }

TEST(TestProtocol, PassesATennisBallThatReboundsAsItShould) {
  runs({"itf-ball-rebound", "drop_100in", "pass", {"temperature_c=20"}});
}

TEST(TestProtocol, FailsATennisBallThatIsDead) {
  // 135 cm is the least.
  runs({"itf-ball-rebound", "drop_100in", "fail", {"temperature_c=20"}, {{"rebound_height_m = 1.4097", "rebound_height_m = 1.15"}}});
}

TEST(TestProtocol, PassesBallsWithoutADrawnLine) {
  runs({"basketball-rebound", "drop_basketball", "pass", {"temperature_c=20"}});
  runs({"pickleball-bounce", "drop_pickleball", "pass", {"temperature_c=25"}});
  runs({"table-tennis-table", "drop_table_tennis", "pass", {"temperature_c=20"}});
}

TEST(TestProtocol, GoesOnWhereItWasInterrupted) {
  ReadyRig bench(rig_of(kCourtPace));
  // Nobody presses Enter after the first ball: its block is fired, and no other.
  strobe::testing::Command begun = fire_by(bench, kCourtPace, {"--protocol", kCourtPace.protocol, "--seed", "5"});
  std::erase(begun.arguments, "--no-pause");
  const CompletedProcess first = ran(begun, 1);
  STRCMP_CONTAINS("--resume", first.err.c_str());
  LONGS_EQUAL(2, verdict_of(bench).at("left").size());
  CHECK_EQUAL("incomplete", verdict_of(bench).at("outcome").get<std::string>());
  // Another protocol does not fit what the session holds.
  ran(fire_by(bench, kCourtPace, {"--protocol", "itf-ball-rebound"}), 2);
  Case resumed = kCourtPace;
  resumed.notes.clear();  // they are the first run's
  ran(fire_by(bench, resumed, {"--resume"}));
  LONGS_EQUAL(9, count_of(verdict_of(bench), "counts"));
}

TEST(TestProtocol, FiresAgainWhatDoesNotConform) {
  Case slow = kCourtPace;
  // 28 m/s is the least: half of the balls are slower.
  slow.scene_edits = {{"speed_mps = 30", "speed_mps = 28"}};
  ReadyRig bench(rig_of(slow));
  const CompletedProcess fired = run_process(fire_by(bench, slow, {"--protocol", slow.protocol}), kLongestWait);
  const json verdict = verdict_of(bench);
  const long replaced = count_of(verdict, "not_conforming");
  CHECK_TRUE(replaced > 0);
  STRCMP_CONTAINS("is fired again", fired.err.c_str());
  LONGS_EQUAL(replaced + count_of(verdict, "rejected"), verdict.at("replaced").get<long>());
  // Nine count, or the nine replacements were not enough.
  CHECK_TRUE(count_of(verdict, "counts") == 9 || verdict.at("replaced").get<long>() >= 9);
}

TEST(TestProtocol, RefusesToBeginWithoutWhatHasToBeNoted) {
  Case unnoted = kCourtPace;
  unnoted.notes.clear();
  RigFixtureOptions options = rig_of(unnoted);
  options.rig_edits = {{"temperature_c = 23.0", ""}};
  RigFixture bench(options);
  const CompletedProcess fired = ran(fire_by(bench, unnoted, {"--protocol", unnoted.protocol}), 2);
  STRCMP_CONTAINS("--note temperature_c=", fired.err.c_str());
}
