#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <string>

#include "tests/hil/line_changes.hpp"
#include "tests/hil/truth_score.hpp"
#include "tests/support/json_lines.hpp"
#include "tests/support/process.hpp"
#include "tests/support/string_from.hpp"
#include "tests/support/temporary_folder.hpp"

#include "tests/hil/expectations.hpp"
#include <CppUTest/TestHarness.h>

using namespace strobe::hil;
using namespace strobe::testing;
using namespace std::chrono_literals;
namespace fs = std::filesystem;

namespace {

/// strobed beside a series of three, both in the rig's time. Its arguments: strobed --config RIG --session SESSION ...
std::string script(const fs::path& camera) {
  return "\"$@\" & strobed=$!; cd \"${3%/*}\"; sleep 2; \"" + program("strobe").string() +
         "\" fire --rig \"$3\" --lcm-url \"$STROBE_TEST_URL\" --session \"$5\" --shots 3 --retries 0 "
         "--effort fast"
         " --json --photographs \"" +
         camera.string() + "\" > readouts.jsonl; status=$?; kill $strobed; wait; exit $status";
}

/// What a run left, by name, but what names its folders.
std::map<std::string, std::string> bytes_of_run(std::uint64_t seed, const fs::path& camera) {
  RigFixtureOptions options = with_small_photographs(short_shots(), camera);
  options.seed = seed;
  options.shell = script(camera);
  options.lcm_url = private_lcm_url();
  options.environment["STROBE_TEST_URL"] = options.lcm_url;
  options.sim_options.insert(options.sim_options.end(), {"--time", "fast", "--clock-start", "1000"});
  RigFixture bench(options);
  const auto ended = bench.sim().wait(kLongestWait);
  CHECK_TEXT(ended == ExitStatus({0, 0}), bench.log().c_str());
  std::map<std::string, std::string> left;
  for (const auto& entry : fs::recursive_directory_iterator(bench.folder())) {
    const std::string name = fs::relative(entry.path(), bench.folder());
    const bool names_folders = name.ends_with("shots.txt") || name.ends_with("runs.jsonl");
    const std::string kind = entry.path().extension();
    if (!names_folders && (kind == ".csv" || kind == ".jsonl" || kind == ".lcmlog" || kind == ".tif"))
      left[name] = read_text(entry.path());
  }
  return left;
}

int files_in(const std::filesystem::path& folder) {
  int count = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder)) ++count;
  return count;
}

/// Share of the incoming speed by which the velocities are off. A centre that is off by a whole pixel at both
/// ends of a leg of four images would make 2 %.
double worst_share(const nlohmann::json& readout, const nlohmann::json& truth) {
  double worst = 0.0;
  for (const char* name : {"vx_td_mps", "vy_td_mps", "vx_lo_mps", "vy_lo_mps"}) {
    const double error = readout.at(name).get<double>() - truth.at("readout").at(name).get<double>();
    worst = std::max(worst, std::abs(error) / truth.at("readout").at("v_td_mps").get<double>());
  }
  return worst;
}

}  // namespace

TEST_GROUP(LineChanges) {
  const LineChanges changes{{{100, "SHUTTER", 1, "set"},
                             {150, "SHUTTER", 1, "set"},
                             {400, "SHUTTER", 0, "set"},
                             {200, "TRIGGER", 1, "set"},
                             {220, "TRIGGER", 0, "release"},
                             {300, "KEY", 1, "drive"}}};
};

TEST(LineChanges, CountRisesAndNotRepeatedLevels) {
  CHECK_EQUAL(1, changes.rises("SHUTTER"));
  CHECK_EQUAL(0, changes.rises("SHUTTER", 101));
  CHECK_EQUAL(1, changes.rises("TRIGGER", 200, 200));
  CHECK_EQUAL(0, changes.rises("STROBE_A"));
}

TEST(LineChanges, TellTheLevelAtAnInstant) {
  CHECK_EQUAL(0, changes.level_at("SHUTTER", 99));
  CHECK_EQUAL(1, changes.level_at("SHUTTER", 100));
  CHECK_EQUAL(0, changes.level_at("SHUTTER", 400));
}

TEST(LineChanges, TellFromWhenOnTheOutputsAreSafe) {
  CHECK_EQUAL(400, changes.outputs_safe_from(0));
  CHECK_EQUAL(500, changes.outputs_safe_from(500));
  const LineChanges stuck{{{100, "STROBE_B", 1, "set"}}};
  CHECK_EQUAL(INT64_MAX, stuck.outputs_safe_from(0));
}

TEST(LineChanges, TellFromWhenOnTheOutputsAreInactiveWithinASpan) {
  CHECK_EQUAL(400, changes.inactive_from(180, 450));
  CHECK_EQUAL(INT64_MAX, changes.inactive_from(180, 350));
  const LineChanges twice{{{100, "SHUTTER", 1, "set"},
                           {130, "SHUTTER", 0, "set"},
                           {500, "SHUTTER", 1, "set"},
                           {530, "SHUTTER", 0, "set"}}};
  CHECK_EQUAL(130, twice.inactive_from(110, 300));
  CHECK_EQUAL(200, twice.inactive_from(200, 300));
}

TEST(LineChanges, AreReadFromTheChipsFile) {
  const TemporaryFolder folder;
  write_text(folder / "changes.csv", "time_ns,line,name,level,cause\n7,3,TRIGGER,1,set\n");
  const LineChanges read(folder / "changes.csv");
  CHECK_EQUAL(1, read.rises("TRIGGER", 7, 7));
}

// All programs of a rig in one time that goes as fast as they let it: the same seed, the same shots, whatever else the
// machine does.

TEST_GROUP(Repeat) {
  TemporaryFolder camera;
  TemporaryFolder camera_again;
};

TEST(Repeat, ASeedGivesTheSameBytes) {
  const auto first = bytes_of_run(5, camera.path());
  const auto second = bytes_of_run(5, camera_again.path());
  CHECK_EQUAL(3U, readouts(first.at("readouts.jsonl")).size());
  CHECK_EQUAL(first.size(), second.size());
  CHECK_TEXT(
      std::ranges::count_if(first, [](const auto& file) { return file.first.ends_with(".lcmlog"); }) == 2,
      "the journal and the host's log");
  for (const auto& [name, bytes] : first) CHECK_TEXT(second.at(name) == bytes, name.c_str());
}

TEST(Repeat, AnotherSeedGivesOtherShots) {
  const auto first = bytes_of_run(5, camera.path());
  const auto second = bytes_of_run(6, camera_again.path());
  CHECK(first.at("readouts.jsonl") != second.at("readouts.jsonl"));
  CHECK(first.at("changes.csv") != second.at("changes.csv"));
}

TEST(Repeat, TenMinutesPassAtOnceWhereNobodyWorks) {
  RigFixtureOptions options;
  options.sim_options = {"--no-digitizer", "--time", "fast", "--clock-start", "1000"};
  options.shell = "date -u +%s; sleep 600; date -u +%s";
  RigFixture bench(options);
  CHECK(bench.sim().wait(kLongestWait) == ExitStatus({0, 0}));
  STRCMP_EQUAL("946685800\n946686400\n", bench.sim().out().c_str());
}

// From the camera's photograph to the readout, with the shipped programs: photographs rendered as the shutter
// closes, found in the folder, matched, digitized, reduced; recomputed from the log without them.

TEST_GROUP(Photographs){};

TEST(Photographs, AreReadOutAsTheyArriveAndAJunkFileStopsNothing) {
  const TemporaryFolder camera;
  write_text(camera / "old.tif", "of another day");
  ReadyRig bench(with_small_photographs(short_shots(), camera.path()));
  auto fire = bench.start(bench.fire(2, 0, {"--photographs", camera.path(), "--effort", "fast"}));
  CHECK(fire.wait_for_err("photographs from", kLongestWait));
  write_text(camera / "junk.tif", "no photograph");
  const auto status = fire.wait(240s);
  CHECK_TEXT(status == ExitStatus({0, 0}), fire.err().c_str());
  STRCMP_CONTAINS("junk.tif", fire.err().c_str());
  STRCMP_CONTAINS("coded train: intervals of 3000 to ", fire.err().c_str());
  CHECK_TEXT(fire.err().find("old.tif") == std::string::npos, fire.err().c_str());
  const std::string printed = fire.out();
  bench.finish();

  int good = 0;
  for (const auto& readout : readouts(printed)) {
    if (is_rejected(readout) || !is_complete(readout)) continue;
    for (const auto& truth : bench.truths()) {
      if (truth.at("shot_id") != readout.at("shot_id")) continue;
      ++good;
      // The shipped plan's train: its intervals tell the flashes.
      CHECK_TEXT(readout.at("misassignment_probability").get<double>() < 0.01, readout.dump().c_str());
      CHECK_TEXT(worst_share(readout, truth) < 0.02, readout.dump().c_str());
    }
  }
  CHECK(good >= 1);
  const std::string plan = read_text(bench.session() / "plan.toml");
  STRCMP_CONTAINS("intervals_us = [3000, ", plan.c_str());
  CHECK(files_in(bench.session() / "photographs") >= 2);

  std::filesystem::remove_all(bench.session() / "photographs");
  const auto replayed = ran(bench.strobe({"replay", host_log(bench.session()), "--json"}));
  CHECK_EQUAL(readout_lines(printed), readout_lines(replayed.out));
}
