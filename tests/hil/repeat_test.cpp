// All programs of a rig in one time that goes as fast as they let it: the same seed, the same shots, whatever else the
// machine does.
#include <filesystem>
#include <map>
#include <sstream>
#include <string>

#include "tests/hil/rig_fixture.hpp"
#include "tests/hil/short_shots.hpp"
#include "tests/support/process.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe::hil;
using strobe::testing::ExitStatus;
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

/// What a run left of tables, by name.
std::map<std::string, std::string> bytes_of_run(std::uint64_t seed, const fs::path& camera) {
  RigFixtureOptions options = with_small_photographs(short_shots(), camera);
  options.seed = seed;
  options.shell = script(camera);
  options.lcm_url = strobe::testing::private_lcm_url();
  options.environment["STROBE_TEST_URL"] = options.lcm_url;
  options.sim_options.insert(options.sim_options.end(), {"--time", "fast", "--clock-start", "1000"});
  RigFixture bench(options);
  const auto ended = bench.sim().wait(kLongestWait);
  CHECK_TEXT(ended == ExitStatus({0, 0}), bench.log().c_str());
  std::map<std::string, std::string> left;
  for (const auto& entry : fs::recursive_directory_iterator(bench.folder())) {
    const std::string name = fs::relative(entry.path(), bench.folder());
    if (name.ends_with(".csv") || name.ends_with(".jsonl"))
      left[name] = strobe::testing::read_text(entry.path());
  }
  return left;
}

/// The lines of a table without its first column.
std::string without_times(const std::string& csv) {
  std::string rest;
  std::istringstream lines(csv);
  for (std::string line; std::getline(lines, line);) rest += line.substr(line.find(',') + 1) + "\n";
  return rest;
}

}  // namespace

TEST_GROUP(Repeat) {
  strobe::testing::TemporaryFolder camera;
  strobe::testing::TemporaryFolder camera_again;
};

TEST(Repeat, ASeedGivesTheSameChangesOfLinesInTheSameOrder) {
  const auto first = bytes_of_run(5, camera.path());
  const auto second = bytes_of_run(5, camera_again.path());
  CHECK_EQUAL(first.size(), second.size());
  CHECK_EQUAL(3U, readouts(first.at("readouts.jsonl")).size());
  CHECK_EQUAL(3U, readouts(second.at("readouts.jsonl")).size());
  CHECK_EQUAL(without_times(first.at("changes.csv")), without_times(second.at("changes.csv")));
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
