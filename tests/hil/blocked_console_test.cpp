// Standard error blocked, as by Ctrl-S or by a pipe that nobody empties: strobed hears and obeys all the same.
#include <csignal>

#include "tests/hil/raw_host.hpp"
#include "tests/hil/rig_fixture.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::hil;
using namespace std::chrono_literals;
using strobe_msgs::command_t;

namespace {

/// Of strobed: a pipe of its own that holds 64 KiB already and that nobody reads.
const char* const kBlocked =
    "mkfifo \"$5/../stderr\" && exec 3<>\"$5/../stderr\" && dd if=/dev/zero bs=4096 count=16 >&3 2>/dev/null "
    "&& "
    "exec \"$@\" 2>&3";

}  // namespace

TEST_GROUP(BlockedConsole){};

TEST(BlockedConsole, KeepsNeitherACommandNorAStatusNorTheEnd) {
  RigFixtureOptions options;
  options.shell = kBlocked;
  options.strobed_options = {"--verbose"};  // a line for each event
  RigFixture bench(options);
  RawHost host(bench);
  CHECK(host.wait_status());
  for (int round = 0; round < 3; ++round) {
    host.send_bytes(std::vector<std::uint8_t>(100, 1));  // told of on standard error, too
    CHECK(host.arm() != 0);
    host.send(host.command(command_t::DISARM));
    CHECK(host.wait([&] { return host.status().arm_token == 0; }, kLongestWait));
  }
  CHECK(host.status().rejected_malformed > 0);
  const pid_t guardian = bench.guardian();
  CHECK(guardian != 0);
  kill(bench.worker(), SIGKILL);  // the guardian has something to say, too
  CHECK(strobe::testing::wait_until([&] { return bench.guardian() == 0; }, kLongestWait));
  CHECK(bench.finish().outputs_safe_from(0) < INT64_MAX);
}
