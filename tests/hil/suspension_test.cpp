// What a machine that sleeps, or whose wall clock is set, does to a series: played in rig time, for all its
// programs at once.
#include <algorithm>

#include "tests/hil/expect_ready.hpp"
#include "tests/hil/raw_host.hpp"
#include "tests/hil/rig_fixture.hpp"
#include "tests/hil/short_shots.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe::hil;
using strobe::testing::ExitStatus;

namespace {

bool has(const std::string& text, const char* words) { return text.find(words) != std::string::npos; }

}  // namespace

TEST_GROUP(Suspension) {
  RigFixture bench{short_shots()};

  /// A series during whose first or second shot the clocks are set. Returns what it said.
  std::string fire(int shots, const std::vector<std::string>& clocks, ExitStatus expected) {
    expect_ready(bench);
    std::vector<std::string> words{program("strobe-sim"), "clock",   "--chip-dir",
                                   bench.chip_dir(),      "--after", "STROBE_A=10"};
    words.insert(words.end(), clocks.begin(), clocks.end());
    auto setting = bench.start({words, {}, {}});
    const auto fired = strobe::testing::run_process(bench.fire(shots, 0, {"--plain"}), kLongestWait);
    CHECK_TEXT(fired.status == expected, fired.err.c_str());
    CHECK_EQUAL(ExitStatus({0, 0}), setting.wait(kLongestWait));
    return fired.err;
  }
};

TEST(Suspension, DuringAShotEndsItAndTheSeries) {
  const std::string said = fire(3, {"--suspend", "600"}, {1, 0});
  CHECK_TEXT(has(said, "computer was suspended"), said.c_str());
  bench.finish();
  const LogContents journal = read_log(bench.journal());
  CHECK(std::ranges::any_of(journal.events, [](const auto& event) {
    return event.kind == strobe_msgs::event_t::SHOT_ABORTED && has(event.detail, "the machine was suspended");
  }));
  CHECK(journal.shots.size() < 3);
}

TEST(Suspension, AWallClockSetBackAnHourTouchesNoShot) {
  const std::string said = fire(3, {"--step", "-3600"}, {0, 0});
  CHECK_TEXT(has(said, "was set by -3600.0 s; times measured are not touched"), said.c_str());
  CHECK_TEXT(has(said, "3 of 3 shots counted, 0 fired again"), said.c_str());
}

TEST(Suspension, IsNotPlayedWhereARigLivesInTheMachinesTime) {
  RigFixtureOptions options;
  options.sim_options = {"--time", "real"};
  RigFixture real(options);
  expect_ready(real);
  const auto refused = strobe::testing::run_process(
      {{program("strobe-sim"), "clock", "--chip-dir", real.chip_dir(), "--suspend", "1"}, {}, {}},
      kLongestWait);
  CHECK_EQUAL(ExitStatus({1, 0}), refused.status);
  CHECK_TEXT(has(refused.err, "--time wall or fast is wanted"), refused.err.c_str());
}
