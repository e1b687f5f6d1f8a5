// Edges that the kernel had no room for are told by the shot in which they were lost, and by no other.
#include <algorithm>
#include <csignal>
#include <filesystem>
#include <string>

#include "tests/hil/expect_ready.hpp"
#include "tests/hil/line_watcher.hpp"
#include "tests/hil/raw_host.hpp"
#include "tests/hil/rig_fixture.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::hil;

namespace {

constexpr int kKernelBuffer = 1024;  // of all inputs with libgpiod 2; 16 a line with 1.6
constexpr int kFlood = kKernelBuffer + 100;
constexpr int kOthers =
    10;  // edges of the rig's own sensors meanwhile, at most: the flashes are 100 ms apart

/// Time enough between two flashes to be stopped, flooded and woken.
RigFixtureOptions slow_train() {
  RigFixtureOptions options;
  options.rig_edits = {{"period_us = 3000", "period_us = 100000"},
                       {"shutter_open_ms = 500", "shutter_open_ms = 1500"},
                       {"impact_at_ms = 250", "impact_at_ms = 700"}};
  return options;
}

/// A process is stopped by its first thread, which on a busy machine comes late to it; the others go on until then.
bool stands_still(pid_t pid) {
  const std::filesystem::directory_iterator threads("/proc/" + std::to_string(pid) + "/task");
  return std::all_of(begin(threads), end(threads), [](const auto& thread) {
    const std::string stat = strobe::testing::read_text(thread.path() / "stat");
    return stat.find(") T ") != std::string::npos;
  });
}

/// Stops whoever reads edges just after the third flash, and makes it miss some. False: the shot ended before.
bool flood_in_mid_train(const RigFixture& bench, strobe::testing::Process& fire) {
  LineWatcher watch(bench.chip_dir());
  for (int flash = 0; flash < 3; ++flash)
    if (watch.wait_for("STROBE_A", 1, fire) == 0) return false;
  const pid_t reader = bench.worker();
  watch.hold_time();  // a reader that is stopped for too long makes its next flash late
  kill(reader, SIGSTOP);
  CHECK(strobe::testing::wait_until([&] { return stands_still(reader); }, kLongestWait));
  for (int i = 0; i < kFlood; ++i)
    for (const int level : {1, 0}) watch.drive("SENSOR_A", level);
  kill(reader, SIGCONT);
  watch.release_time();
  return true;
}

}  // namespace

TEST_GROUP(LostEdges){};

TEST(LostEdges, AreToldByTheShotWhoseReaderStoodStill) {
  RigFixture bench(slow_train());
  expect_ready(bench);
  strobe::testing::Process fire = bench.start(bench.fire(1, 0));
  CHECK_TEXT(flood_in_mid_train(bench, fire), bench.log().c_str());
  CHECK(fire.wait(kLongestWait).has_value());
  const auto flooded = readouts(fire.out()).at(0);
  CHECK_TEXT(has_flag(flooded, "events_missing"), flooded.dump().c_str());
  const auto next = strobe::testing::run_process(bench.fire(1, 0), kLongestWait);
  CHECK_TEXT(!has_flag(readouts(next.out).at(0), "events_missing"), next.out.c_str());
  const auto shots = read_log(bench.journal()).shots;
  LONGS_EQUAL(2, shots.size());
  // 1.6 tells that a buffer was full, 2 counts what is missing.
  const std::int64_t lost = shots[0].kernel_overflows;
  CHECK_TEXT(lost == 1 || (lost >= kFlood - kKernelBuffer && lost <= kFlood - kKernelBuffer + kOthers),
             std::to_string(lost).c_str());
  LONGS_EQUAL(0, shots[1].kernel_overflows);
}
