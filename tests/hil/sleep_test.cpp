// The machine is kept awake from ARM on, and no longer than strobed lives.
#include <csignal>
#include <cstdlib>
#include <string>

#include "tests/hil/expect_ready.hpp"
#include "tests/hil/raw_host.hpp"
#include "tests/hil/rig_fixture.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::hil;
using strobe::testing::wait_until;

TEST_GROUP(Sleep) {
  strobe::testing::TemporaryFolder folder;

  /// Stands in for systemd-inhibit, which needs a logind.
  std::map<std::string, std::string> with_inhibit(const std::string& script) const {
    const auto program = folder / "systemd-inhibit";
    strobe::testing::write_text(program, "#!/bin/sh\n" + script + "\n");
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
  RigFixture bench(options);
  expect_ready(bench);
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
  RigFixture bench(options);
  expect_ready(bench);
  RawHost host(bench);
  CHECK(host.wait_status());
  CHECK(host.arm() != 0);
  CHECK(wait_until(
      [&] {
        return bench.log().find("warning: nothing keeps this machine from going to sleep") !=
               std::string::npos;
      },
      kLongestWait));
  const std::int64_t token = host.status().arm_token;
  host.send(host.fire_command(token, true));
  CHECK(host.wait([&] { return !host.shots().empty(); }, kLongestWait));
}
