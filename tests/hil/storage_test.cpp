// The shipped `strobe fire` on a disk that fails: a file that may not grow, a standard output that takes nothing, a
// folder that is removed. What a person is told, and the exit status.
#include <fstream>
#include <lcm/lcm-cpp.hpp>

#include "tests/hil/expect_ready.hpp"
#include "tests/hil/rig_fixture.hpp"
#include "tests/hil/short_shots.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe::hil;
using namespace std::chrono_literals;
using strobe::testing::Command;
using strobe::testing::CompletedProcess;
using strobe::testing::ExitStatus;

namespace {

/// As a shell runs it; the command is "$@".
Command through_shell(const std::string& script, const Command& command) {
  Command shell = command;
  shell.arguments = {"sh", "-c", script, "sh"};
  shell.arguments.insert(shell.arguments.end(), command.arguments.begin(), command.arguments.end());
  return shell;
}

Command fire_elsewhere(RigFixture& bench, int shots) {
  return bench.strobe({"fire", "--shots", std::to_string(shots), "--retries", "0", "--session",
                       bench.folder() / "host", "--json"});
}

}  // namespace

TEST_GROUP(Storage) {
  RigFixture bench{short_shots()};
  void setup() override { expect_ready(bench); }
};

TEST(Storage, ALogThatMayNotGrowEndsTheSeriesWithItsNameTheReasonAndWhatIsMissing) {
  constexpr std::uintmax_t kLimit_bytes = 100 * 1024;
  const CompletedProcess fired = strobe::testing::run_process(
      through_shell("ulimit -f 200; exec \"$@\"", fire_elsewhere(bench, 50)), kLongestWait);  // of 512 bytes
  CHECK_TEXT(fired.status == ExitStatus({1, 0}), fired.err.c_str());
  CHECK_TEXT(fired.err.find(".lcmlog: cannot be written: File too large") != std::string::npos,
             fired.err.c_str());
  CHECK_TEXT(fired.err.find(".lcmlog: not stored: ") != std::string::npos, fired.err.c_str());
  const auto path = host_log(bench.folder() / "host");
  CHECK(std::filesystem::file_size(path) <= kLimit_bytes);
  lcm::LogFile log(path, "r");
  std::uintmax_t bytes = 0;
  while (const lcm::LogEvent* event = log.readNextEvent())
    bytes += 28 + event->channel.size() + static_cast<std::uintmax_t>(event->datalen);
  LONGS_EQUAL(std::filesystem::file_size(path), bytes);  // whole records, to the last byte
}

TEST(Storage, AStandardOutputThatTakesNothingEndsTheSeries) {
  const CompletedProcess fired = strobe::testing::run_process(
      through_shell("exec \"$@\" >/dev/full", fire_elsewhere(bench, 50)), kLongestWait);
  CHECK_TEXT(fired.status == ExitStatus({1, 0}), fired.err.c_str());
  CHECK_TEXT(fired.err.find("standard output: cannot be written: No space left") != std::string::npos,
             (fired.err + bench.log()).c_str());
}

TEST(Storage, AFolderThatIsRemovedUnderItEndsTheSeries) {
  auto fire = bench.start(fire_elsewhere(bench, 50));
  CHECK_TEXT(fire.wait_for_out("vx_td_mps", kLongestWait), fire.err().c_str());
  std::filesystem::remove_all(bench.folder() / "host");
  const auto ended = fire.wait(kLongestWait);
  CHECK_TEXT(ended == ExitStatus({1, 0}), fire.err().c_str());
  CHECK_TEXT(fire.err().find("results.csv: is no longer there") != std::string::npos, fire.err().c_str());
}
