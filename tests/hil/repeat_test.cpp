// All programs of a rig in one time that goes as fast as they let it: the same seed, the same shots, whatever else the
// machine does.
#include <algorithm>
#include <filesystem>
#include <map>
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

/// What a run left, by name, but what names its folders.
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
    const bool names_folders = name.ends_with("shots.txt") || name.ends_with("runs.jsonl");
    const std::string kind = entry.path().extension();
    if (!names_folders && (kind == ".csv" || kind == ".jsonl" || kind == ".lcmlog" || kind == ".tif"))
      left[name] = strobe::testing::read_text(entry.path());
  }
  return left;
}

}  // namespace

TEST_GROUP(Repeat) {
  strobe::testing::TemporaryFolder camera;
  strobe::testing::TemporaryFolder camera_again;
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
