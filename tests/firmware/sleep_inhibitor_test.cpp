#include "firmware/linux/sleep_inhibitor.hpp"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <optional>
#include <string>
#include <vector>

#include "tests/support/process.hpp"
#include "tests/support/temporary_folder.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using firmware::SleepInhibitor;
using testing::read_text;
using testing::wait_until;

namespace {

constexpr std::chrono::seconds kLongestWait{60};
constexpr MonoTime kStart = from_ns(100'000'000'000);

}  // namespace

TEST_GROUP(SleepInhibitor) {
  testing::TemporaryFolder folder;
  std::string path_before = std::getenv("PATH");
  std::vector<std::string> said;
  std::optional<SleepInhibitor> inhibitor;

  void setup() override {
    inhibitor.emplace([this](const std::string& line) { said.push_back(line); });
    put_inhibit(
        "echo $$ >$0.pid; echo \"$*\" >>$0.begun; while [ \"${1#--}\" != \"$1\" ]; do shift; done; "
        "\"$@\"; echo \"$?\" >>$0.ended");
  }
  void teardown() override {
    inhibitor.reset();
    setenv("PATH", path_before.c_str(), 1);
  }

  /// Stands in for systemd-inhibit, first on the PATH.
  void put_inhibit(const std::string& script) {
    const auto program = folder / "systemd-inhibit";
    testing::write_text(program, "#!/bin/sh\n" + script + "\n");
    std::filesystem::permissions(program, std::filesystem::perms::owner_all);
    setenv("PATH", (folder.path().string() + ":" + path_before).c_str(), 1);
  }
  std::string noted(const std::string& what) const {
    const auto file = folder / ("systemd-inhibit." + what);
    return std::filesystem::exists(file) ? read_text(file) : "";
  }
  std::ptrdiff_t count(const std::string& what) const {
    const std::string lines = noted(what);
    return std::count(lines.begin(), lines.end(), '\n');
  }
  bool comes(const std::string& what, std::ptrdiff_t lines = 1) const {
    return wait_until([&] { return count(what) == lines; }, kLongestWait);
  }
};

TEST(SleepInhibitor, HoldsOneLockForTheShotsOfASeries) {
  for (int second = 0; second < 30; ++second)
    inhibitor->turn(second % 4 == 0, kStart + milliseconds(1000) * second);
  CHECK(comes("begun"));
  CHECK_EQUAL("--what=sleep:handle-lid-switch --who=strobed --why=a shot may be under way --mode=block cat\n",
              noted("begun"));
  CHECK_EQUAL(0, count("ended"));
  CHECK(said.empty());
}

TEST(SleepInhibitor, LetsGoSomeSecondsAfterTheLastShotAndComesAgain) {
  inhibitor->turn(true, kStart);
  CHECK(comes("begun"));
  inhibitor->turn(false, kStart + SleepInhibitor::kLinger - milliseconds(1));
  CHECK_EQUAL(0, count("ended"));
  inhibitor->turn(false, kStart + SleepInhibitor::kLinger);
  CHECK(comes("ended"));
  CHECK(wait_until(
      [&] {
        inhibitor->turn(true, kStart + milliseconds(10'000));
        return count("begun") == 2;
      },
      kLongestWait));
  CHECK(said.empty());
}

TEST(SleepInhibitor, EndsItsLockWithItself) {
  inhibitor->turn(true, kStart);
  CHECK(comes("begun"));
  inhibitor.reset();
  CHECK(comes("ended"));
  CHECK_EQUAL("0\n", noted("ended"));
}

TEST(SleepInhibitor, ReplacesALockThatSomebodyKilled) {
  inhibitor->turn(true, kStart);
  CHECK(comes("begun"));
  kill(std::stoi(noted("pid")), SIGKILL);
  CHECK(wait_until(
      [&] {
        inhibitor->turn(true, kStart);
        return count("begun") == 2;
      },
      kLongestWait));
  CHECK(said.empty());
}

TEST(SleepInhibitor, SaysOnceThatTheLockIsRefused) {
  put_inhibit("echo begun >>$0.begun; exit 1");
  CHECK(wait_until(
      [&] {
        inhibitor->turn(true, kStart);
        return !said.empty();
      },
      kLongestWait));
  for (int again = 0; again < 3; ++again) inhibitor->turn(true, kStart + milliseconds(20'000) * again);
  CHECK_EQUAL(1, count("begun"));
  LONGS_EQUAL(1, said.size());
  CHECK_EQUAL(
      "warning: nothing keeps this computer from going to sleep while a shot is under way: systemd-inhibit "
      "ended with "
      "status 1",
      said[0]);
}

TEST(SleepInhibitor, SaysOnceThatThereIsNoProgramForIt) {
  setenv("PATH", (folder / "nothing").c_str(), 1);
  for (int again = 0; again < 3; ++again) inhibitor->turn(true, kStart + milliseconds(20'000) * again);
  LONGS_EQUAL(1, said.size());
  STRCMP_CONTAINS("systemd-inhibit: No such file", said[0].c_str());
}
