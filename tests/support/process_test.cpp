#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <lcm/lcm-cpp.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/support/private_network.hpp"
#include "tests/support/process.hpp"
#include "tests/support/string_from.hpp"
#include "tests/support/temporary_folder.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::testing;
using namespace std::chrono_literals;

namespace {

constexpr const char* kUrl = "udpm://239.255.76.67:7667?ttl=0";

struct Count {
  int messages = 0;
  void take(const lcm::ReceiveBuffer*, const std::string&) { ++messages; }
};

/// Runs a function in a forked child and returns its exit status.
template <typename Function>
int in_child(Function function) {
  const pid_t child = fork();
  if (child == 0) _exit(function());
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

/// A message to oneself by multicast: the only way to know that LCM works here.
int lcm_round_trip() {
  if (!enter_private_network().empty()) return 77;
  lcm::LCM lcm(kUrl);
  if (!lcm.good()) return 1;
  Count count;
  lcm.subscribe("CHANNEL", &Count::take, &count);
  const std::string text = "text";
  lcm.publish("CHANNEL", text.data(), static_cast<unsigned>(text.size()));
  return lcm.handleTimeout(5000) > 0 && count.messages == 1 ? 0 : 2;
}

}  // namespace

TEST_GROUP(Process) {
  TemporaryFolder logs;
  static Command shell(const std::string& script) {
    return {{"sh", "-c", script}, {}, {}, Privileges::inherited};
  }
};

TEST(Process, TellsOutputErrorsAndExitStatus) {
  const CompletedProcess finished = run_process(shell("echo out; echo err >&2; exit 3"), 10s);
  CHECK_EQUAL(ExitStatus({3, 0}), finished.status);
  CHECK_EQUAL("out\n", finished.out);
  CHECK_EQUAL("err\n", finished.err);
}

TEST(Process, TellsTheSignalThatEndedIt) {
  const CompletedProcess finished = run_process(shell("kill -TERM $$"), 10s);
  CHECK_EQUAL(ExitStatus({-1, SIGTERM}), finished.status);
}

TEST(Process, HeedsSignalsThatTheTestItselfIgnores) {
  const auto before = std::signal(SIGINT, SIG_IGN);
  const CompletedProcess finished = run_process(shell("kill -INT $$; exit 3"), 10s);
  std::signal(SIGINT, before);
  CHECK_EQUAL(ExitStatus({-1, SIGINT}), finished.status);
}

TEST(Process, HasNoStandardInput) {
  const CompletedProcess finished = run_process({{"cat"}, {}, {}, Privileges::inherited}, 10s);
  CHECK_EQUAL(ExitStatus({0, 0}), finished.status);
}

TEST(Process, AddsToTheEnvironmentAndReplacesInIt) {
  Command command = shell("echo $STROBE_A; echo ${HOME}");
  command.environment = {{"STROBE_A", "1"}, {"HOME", "/elsewhere"}};
  CHECK_EQUAL("1\n/elsewhere\n", run_process(command, 10s).out);
}

TEST(Process, StartsInTheFolderGiven) {
  Command command = shell("pwd");
  command.folder = logs.path();
  CHECK_EQUAL(std::filesystem::canonical(logs.path()).string() + "\n", run_process(command, 10s).out);
}

TEST(Process, IsNotWaitedForBeyondTheLimit) {
  Process process(shell("sleep 60"), logs.path());
  CHECK_FALSE(process.wait(20ms).has_value());
  CHECK(process.running());
  process.signal_group(SIGTERM);
  CHECK_EQUAL(ExitStatus({-1, SIGTERM}), process.wait(10s));
}

TEST(Process, LeavesNoneOfItsGroupBehind) {
  pid_t grandchild = 0;
  {
    Process process(shell("sleep 60 & echo $!; wait"), logs.path());
    CHECK(process.wait_for_out("\n", 10s));
    grandchild = static_cast<pid_t>(std::stol(process.out()));
    CHECK(!program_of(grandchild).empty());
  }
  CHECK(wait_until([&] { return program_of(grandchild).empty(); }, 10s));
}

TEST(Process, IsFoundAmongTheDescendantsOfItsParent) {
  Process process(shell("sleep 60 & wait"), logs.path());
  CHECK(wait_until([&] { return descendants_of(process.pid()).size() == 2; }, 10s));
  CHECK(wait_until([&] { return program_of(descendants_of(process.pid()).at(1)) == "sleep"; }, 10s));
  const std::vector<pid_t> mine = children_of(getpid());
  CHECK(std::find(mine.begin(), mine.end(), process.pid()) != mine.end());
}

TEST(Process, WaitsForATextUntilItComes) {
  Process process(shell("sleep 0.05; echo ready; sleep 60"), logs.path());
  CHECK(process.wait_for_out("ready", 10s));
}

TEST(Process, GivesUpOnATextOnceTheProcessEnded) {
  Process process(shell("echo something else"), logs.path());
  const std::int64_t start = monotonic_now_ns();
  CHECK_FALSE(process.wait_for_out("ready", 60s));
  CHECK(monotonic_now_ns() - start < 30'000'000'000);
}

TEST(Process, OfAProgramThatIsNotThereExitsAsAShellSays) {
  const CompletedProcess finished = run_process({{"/nowhere/at-all"}, {}, {}, Privileges::inherited}, 10s);
  CHECK_EQUAL(ExitStatus({127, 0}), finished.status);
}

TEST(Process, WithAnOrdinaryUsersRightsHasNeitherCapabilitiesNorRealTime) {
  Command command = shell("grep CapEff /proc/self/status; ulimit -r; ulimit -l");
  command.arguments[0] = "bash";
  command.rights = Privileges::ordinary;
  CHECK_EQUAL("CapEff:\t0000000000000000\n0\n64\n", run_process(command, 10s).out);
}

TEST_GROUP(TemporaryFolder){};

TEST(TemporaryFolder, IsThereAndEmptyAndItsOwn) {
  const TemporaryFolder one;
  const TemporaryFolder other;
  CHECK(std::filesystem::is_empty(one.path()));
  CHECK(one.path() != other.path());
}

TEST(TemporaryFolder, GoesWithAllThatIsInIt) {
  std::filesystem::path path;
  {
    const TemporaryFolder folder;
    path = folder.path();
    std::filesystem::create_directories(folder / "a/b");
    write_text(folder / "a/b/c.txt", "text");
  }
  CHECK_EQUAL(std::getenv("STROBE_KEEP_FOLDERS") != nullptr, std::filesystem::exists(path));
}

TEST(TemporaryFolder, KeepsWhatIsWrittenByteForByte) {
  const TemporaryFolder folder;
  const std::string text("line\r\n\0end", 10);
  write_text(folder / "file", text);
  CHECK_EQUAL(text, read_text(folder / "file"));
}

TEST(TemporaryFolder, ComplainsOfAFileThatCannotBeWritten) {
  const TemporaryFolder folder;
  CHECK_THROWS(std::runtime_error, write_text(folder / "no/such/file", "text"));
}

// Moves the whole test program into a namespace, so it is a program of its own.

TEST_GROUP(PrivateNetwork){};

TEST(PrivateNetwork, CarriesLcm) {
  const int status = in_child(lcm_round_trip);
  if (status == 77) return;  // a container without namespaces: programs fall back to a private port
  CHECK_EQUAL(0, status);
}

TEST(PrivateNetwork, UrlsDifferFromOneToTheNext) { CHECK(private_lcm_url() != private_lcm_url()); }
