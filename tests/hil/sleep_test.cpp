// The machine is kept awake from ARM on, and no longer than strobed lives.
#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <string>

#include "tests/hil/raw_host.hpp"

#include "tests/hil/expectations.hpp"
#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::hil;
using namespace strobe::testing;

namespace {

bool has(const std::string& text, const char* words) { return text.find(words) != std::string::npos; }

}  // namespace

TEST_GROUP(Sleep) {
  TemporaryFolder folder;

  /// Stands in for systemd-inhibit, which needs a logind.
  std::map<std::string, std::string> with_inhibit(const std::string& script) const {
    const auto program = folder / "systemd-inhibit";
    write_text(program, "#!/bin/sh\n" + script + "\n");
    std::filesystem::permissions(program, std::filesystem::perms::owner_all);
    return {{"PATH", folder.path().string() + ":" + std::getenv("PATH")}};
  }
  bool noted(const char* what) const { return std::filesystem::exists(folder / what); }
  bool comes(const char* what) const {
    return wait_until([&] { return noted(what); }, kLongestWait);
  }
};

TEST(Sleep, IsInhibitedWhileArmedAndNotBeyondTheEndOfAKilledStrobed) {
  RigFixtureOptions options;
  options.environment = with_inhibit("cd \"${0%/*}\"; echo >begun; cat; echo >ended");
  ReadyRig bench(options);
  RawHost host(bench);
  CHECK(host.wait_status());
  CHECK(!noted("begun"));
  CHECK(host.arm() != 0);
  CHECK(comes("begun"));
  CHECK(!noted("ended"));
  for (const pid_t pid : {bench.guardian(), bench.worker()}) kill(pid, SIGKILL);
  CHECK(comes("ended"));
}

TEST(Sleep, ThatCannotBeInhibitedIsToldAndNothingElse) {
  RigFixtureOptions options;
  options.environment = with_inhibit("exit 1");
  ReadyRig bench(options);
  RawHost host(bench);
  CHECK(host.wait_status());
  CHECK(host.arm() != 0);
  CHECK(wait_until(
      [&] {
        return bench.log().find("warning: nothing keeps this computer from going to sleep") !=
               std::string::npos;
      },
      kLongestWait));
  const std::int64_t token = host.status().arm_token;
  host.send(host.fire_command(token, true));
  CHECK(host.wait([&] { return !host.shots().empty(); }, kLongestWait));
}

// What a machine that sleeps, or whose wall clock is set, does to a series: played in rig time, for all its
// programs at once.

TEST_GROUP(Suspension) {
  RigFixture bench{short_shots()};

  /// A series during whose first or second shot the clocks are set. Returns what it said.
  std::string fire(int shots, const std::vector<std::string>& clocks, ExitStatus expected) {
    expect_ready(bench);
    std::vector<std::string> words{program("strobe-sim"), "clock",   "--chip-dir",
                                   bench.chip_dir(),      "--after", "STROBE_A=10"};
    words.insert(words.end(), clocks.begin(), clocks.end());
    auto setting = bench.start({words, {}, {}});
    const auto fired = run_process(bench.fire(shots, 0, {"--plain"}), kLongestWait);
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
    return event.kind == strobe_msgs::event_t::SHOT_ABORTED && has(event.detail, "the rig's computer was suspended");
  }));
  CHECK(journal.shots.size() < 3);
}

TEST(Suspension, AWallClockSetBackAnHourTouchesNoShot) {
  const std::string said = fire(3, {"--step", "-3600"}, {0, 0});
  CHECK_TEXT(has(said, "was set by -3600.0 s; measured times are not affected"), said.c_str());
  CHECK_TEXT(has(said, "3 of 3 shots counted, 0 fired again"), said.c_str());
}

TEST(Suspension, IsNotPlayedWhereARigLivesInTheMachinesTime) {
  RigFixtureOptions options;
  options.sim_options = {"--time", "real"};
  ReadyRig real(options);
  const auto refused =
      ran({{program("strobe-sim"), "clock", "--chip-dir", real.chip_dir(), "--suspend", "1"}, {}, {}}, 1);
  CHECK_TEXT(has(refused.err, "--time wall or --time fast"), refused.err.c_str());
}
