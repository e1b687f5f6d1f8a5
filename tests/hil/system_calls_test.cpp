// No system call of strobed's ways is outside the unit's list: what the list refuses is refused only on a
// rig.
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/hil/line_changes.hpp"
#include "tests/hil/raw_host.hpp"
#include "tests/support/fake_service_manager.hpp"

#include "tests/hil/expectations.hpp"
#include <CppUTest/TestHarness.h>

using namespace strobe::hil;
using namespace strobe::testing;
using namespace std::chrono_literals;

namespace {

using Names = std::set<std::string>;

/// systemd's groups of system calls, as `systemd-analyze syscall-filter` prints them; groups in groups by
/// name.
std::map<std::string, Names> groups_in(const std::string& text) {
  std::map<std::string, Names> groups;
  std::istringstream lines(text);
  std::string group;
  for (std::string line; std::getline(lines, line);) {
    const std::size_t begin = line.find_first_not_of(' ');
    if (begin == std::string::npos || line[begin] == '#') continue;
    if (begin == 0) {
      group = line;
    } else {
      groups[group].insert(line.substr(begin));
    }
  }
  return groups;
}

void add(const std::map<std::string, Names>& groups, const std::string& name, Names& to) {
  if (name[0] != '@') {
    to.insert(name);
    return;
  }
  for (const std::string& each : groups.at(name)) add(groups, each, to);
}

/// What the unit's SystemCallFilter lines leave, one after the other.
Names allowed_by(const std::string& unit, const std::map<std::string, Names>& groups) {
  Names allowed;
  add(groups, "@default", allowed);  // implied
  const std::string key = "SystemCallFilter=";
  std::istringstream lines(unit);
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind(key, 0) != 0) continue;
    const bool without = line[key.size()] == '~';
    std::istringstream words(line.substr(key.size() + (without ? 1 : 0)));
    for (std::string word; words >> word;) {
      Names named;
      add(groups, word, named);
      for (const std::string& each : named) {
        if (!without) allowed.insert(each);
        if (without) allowed.erase(each);
      }
    }
  }
  return allowed;
}

constexpr int kTracings = 5;

/// strace of all but these, at nearly no cost for them; execve is told, so that silence means something.
std::string tracing_all_but(Names allowed, const std::filesystem::path& to) {
  allowed.erase("execve");
  std::string command =
      "strace -f --seccomp-bpf --quiet=all -e signal=none -A -o " + to.string() + " -e trace='!";
  for (const std::string& name : allowed) command += (command.back() == '!' ? "?" : ",?") + name;
  return command + "' ";
}

}  // namespace

TEST_GROUP(SystemCalls) {
  TemporaryFolder folder;
  const std::filesystem::path traced = folder / "traced";

  /// Empty if they cannot be traced here; why is printed.
  std::string tracer() const {
    const auto works = run_process(
        {{"strace", "-f", "--seccomp-bpf", "-o", "/dev/null", "true"}, {}, {}, {}}, 20s);
    const auto listed =
        run_process({{"systemd-analyze", "--no-pager", "syscall-filter"}, {}, {}, {}}, 20s);
    if (works.status != ExitStatus({0, 0}) || listed.status != ExitStatus({0, 0})) {
      std::printf("skipped: no strace, no ptrace(2) or no systemd-analyze here ");
      return "";
    }
    const std::string unit = read_text(STROBE_BUILD_DIR "/firmware/strobed.service");
    return tracing_all_but(allowed_by(unit, groups_in(listed.out)), traced);
  }

  static void fire(RigFixture & bench, RawHost & host, LineWatcher & watch) {
    CHECK(host.wait_status());
    const auto shot = [&host](std::int64_t token) { return host.fire_command(token, false); };
    CHECK_TEXT(host.fire_until_flash(watch, shot) != 0, bench.log().c_str());
  }

  /// Every call told: execve of the program, or of what keeps the machine awake, and no other.
  void nothing_but_starts(std::size_t starts) const {
    std::istringstream lines(read_text(traced));
    std::size_t count = 0;
    for (std::string line; std::getline(lines, line);) {
      if (line.find(R"( ???)") != std::string::npos) continue;  // killed before strace knew the call
      const bool start = line.find("execve(") != std::string::npos;
      CHECK_TEXT(start, line.c_str());
      if (line.find("/strobed\", [") != std::string::npos) ++count;
    }
    CHECK_EQUAL(starts, count);
  }
};

TEST(SystemCalls, ListOfTheUnitLeavesWhatItNames) {
  const auto groups = groups_in(
      "@default\n    # always\n    read\n@a\n    # words\n    one\n    @b\n@b\n    two\n    three\n");
  const Names left =
      allowed_by("SystemCallFilter=@a four\nSystemCallFilter=~@b\nSystemCallFilter=two\n", groups);
  CHECK(left == Names({"read", "one", "four", "two"}));
}

TEST(SystemCalls, OfAShotAnEmergencyStopAndAllWaysOutAreInTheUnitsList) {
  const std::string trace = tracer();
  if (trace.empty()) return;
  FakeServiceManager manager(folder / "notify");
  RigFixtureOptions options;
  // Shots that begin soon, since nobody looks at the ball; and none is aborted as late: the tracer stops each
  // thread at each of its first calls.
  options.rig_edits = {{"lag_ms = 310", "lag_ms = 70"}, {"abort_late_us = 1500", "abort_late_us = 1000000"}};
  options.environment = {{"NOTIFY_SOCKET", manager.path()}, {"WATCHDOG_USEC", "20000000"}};
  // Stopped in order; started again on a journal with a torn end, where its outputs fail; then as after its
  // death.
  options.shell = trace + "\"$@\"; for j in \"$5\"/journal-*; do printf torn >>\"$j\"; done; " + trace +
                  "\"$@\" --drill output-failure@1; " + trace + "\"$1\" --safe --config \"$3\"; " + trace +
                  "\"$1\" --check --config \"$3\" --session \"$5\" --lcm-url \"$7\"";
  ReadyRig bench(options);
  LineWatcher watch(bench.chip_dir());
  const pid_t first = bench.guardian();
  {
    RawHost host(bench);
    fire(bench, host, watch);
    watch.drive("ESTOP", 0);
    host.wait([&host] { return !host.shots().empty(); }, 5s);
    watch.drive("ESTOP", 1);
  }
  kill(first, SIGTERM);
  CHECK(wait_until([&] { return bench.guardian() != first && bench.worker() != 0; }, kLongestWait));
  {
    RawHost host(bench);
    fire(bench, host, watch);
    // The publisher may come to its drill when the train is over: the next one fails then.
    bool ended = bench.sim().wait(5s).has_value();
    for (int attempt = 0; !ended && attempt < kTracings; ++attempt) {
      host.send(host.fire_command(host.arm(), false));
      ended = bench.sim().wait(5s).has_value();
    }
    CHECK_TEXT(ended, (host.status().message + "\n" + bench.log()).c_str());
  }
  CHECK(bench.log().find("the guardian made the outputs inactive") != std::string::npos);
  nothing_but_starts(4);
}

TEST(SystemCalls, OutsideTheListAreNoticed) {
  const std::string trace = tracer();
  if (trace.empty()) return;
  run_process({{"sh", "-c", trace + "chroot / true"}, {}, {}, {}}, 20s);
  STRCMP_CONTAINS("chroot(", read_text(traced).c_str());
}
