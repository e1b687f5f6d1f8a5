// Debian's GPIO programs of libgpiod 2, unmodified, against the simulated chip: the installed ones, or on
// Debian 12 those in STROBE_GPIOD2 (tests/gpiod2/download). Skipped where there are neither.
#include <signal.h>

#include <optional>

#include "tests/sim/gpiochip/fixture.hpp"
#include "tests/support/gpio_tools.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::sim;
using testing::CompletedProcess;

namespace {

struct Tools {
  std::string folder;     ///< with a slash at its end; empty: the installed ones
  std::string libraries;  ///< empty: the installed ones
};

std::optional<Tools> downloaded() {
  const std::filesystem::path root = STROBE_GPIOD2_ROOT;
  std::error_code error;
  if (!std::filesystem::exists(root / "usr/bin/gpiodetect", error)) return std::nullopt;
  for (const auto& entry : std::filesystem::directory_iterator(root / "usr/lib", error)) {
    if (std::filesystem::exists(entry.path() / "libgpiod.so.3", error))
      return Tools{root / "usr/bin/", entry.path()};
  }
  return std::nullopt;
}

std::optional<Tools> find_tools() {
  if (testing::gpio_tools_are_of_version_2()) return Tools{};
  const auto found = downloaded();
  if (!found)
    std::printf(
        "skipped: no tools of libgpiod 2 (tests/gpiod2/download, then cmake -DSTROBE_GPIOD2=OUT/root) ");
  return found;
}

}  // namespace

TEST_GROUP(GpioTools2) {
  ChipFixture fixture;
  std::optional<Tools> tools = find_tools();

  testing::Command command(std::vector<std::string> arguments) {
    arguments[0] = tools->folder + arguments[0];
    testing::Command made = fixture.preloaded(std::move(arguments));
    if (!tools->libraries.empty()) made.environment["LD_LIBRARY_PATH"] = tools->libraries;
    return made;
  }

  /// Fails the test with the reason if the tool failed.
  std::string output_of(std::vector<std::string> arguments) {
    const CompletedProcess finished = testing::run_process(command(arguments), kLimit);
    const std::string problem = arguments[0] + " failed: " + finished.err;
    CHECK_TRUE_TEXT(finished.status.has_value() && finished.status->code == 0, problem.c_str());
    return finished.out;
  }

  testing::Process started(std::vector<std::string> arguments) {
    return testing::Process(command(std::move(arguments)), fixture.logs());
  }

  void wait_until_requested(std::uint32_t line, testing::Process & by) {
    CHECK_TRUE(
        testing::wait_until([&] { return fixture.chip().state(line).requested || !by.running(); }, kLimit));
  }

  /// Lets the rig look for released lines, as it does all the time.
  bool said_while_the_rig_looks(testing::Process & process, const std::string& text) {
    return testing::wait_until(
        [&] {
          ChangeCursor cursor = fixture.chip().cursor_now();
          std::vector<Change> changes;
          fixture.chip().wait_changes(cursor, now() + milliseconds(2), changes);
          return process.out().find(text) != std::string::npos;
        },
        kLimit);
  }
};

TEST(GpioTools2, GpiodetectListsTheChip) {
  if (!tools) return;
  CHECK_EQUAL("gpiochip0 [strobe-sim-rig] (16 lines)\n", output_of({"gpiodetect", "gpiochip0"}));
  STRCMP_CONTAINS("gpiochip0 [strobe-sim-rig] (16 lines)\n", output_of({"gpiodetect"}).c_str());
}

TEST(GpioTools2, GpioinfoShowsLinesAndOwnersOfBothVersions) {
  if (!tools) return;
  const auto first = fixture.actor({"hold", "1", "1"});
  const auto second = fixture.actor({"late", "4", "0"}, "ready", "gpio_actor_v2");
  const std::string out = output_of({"gpioinfo", "-c", "gpiochip0"});
  STRCMP_CONTAINS("gpiochip0 - 16 lines:\n", out.c_str());
  STRCMP_CONTAINS("line   0:\t\"STROBE_A\"      \tinput\n", out.c_str());
  STRCMP_CONTAINS("line   1:\t\"STROBE_B\"      \toutput consumer=\"actor\"\n", out.c_str());
  STRCMP_CONTAINS("line   4:\t\"SENSOR_A\"      \tinput edges=both consumer=\"actor\"\n", out.c_str());
  STRCMP_CONTAINS("gpiochip0 8\t\"ESTOP\"", output_of({"gpioinfo", "ESTOP"}).c_str());
}

TEST(GpioTools2, GpiogetReadsLevelsByNameAndOffset) {
  if (!tools) return;
  fixture.chip().drive(4, 1, now());
  CHECK_EQUAL("\"STROBE_A\"=inactive \"SENSOR_A\"=active\n", output_of({"gpioget", "STROBE_A", "SENSOR_A"}));
  CHECK_EQUAL("0 1 1\n", output_of({"gpioget", "--numeric", "-c", "gpiochip0", "0", "4", "8"}));
  CHECK_EQUAL("1 0 0\n", output_of({"gpioget", "--numeric", "--active-low", "-c", "0", "0", "4", "8"}));
  CHECK_EQUAL("1\n", output_of({"gpioget", "--numeric", "--bias", "pull-up", "-c", "/dev/gpiochip0", "8"}));
}

TEST(GpioTools2, GpiosetHoldsItsLinesUntilItEnds) {
  if (!tools) return;
  auto setter = started({"gpioset", "-c", "gpiochip0", "0=1", "2=1", "3=0"});
  wait_until_requested(2, setter);
  const std::vector<Change> changes = fixture.changes(2);
  LONGS_EQUAL(2, changes.size());
  CHECK_EQUAL(changes[1].time, changes[0].time);
  const CompletedProcess second =
      testing::run_process(command({"gpioset", "-c", "gpiochip0", "2=0"}), kLimit);
  STRCMP_CONTAINS("busy", second.err.c_str());
  setter.signal(SIGTERM);
  setter.wait(kLimit);
  CHECK_FALSE(fixture.chip().state(2).requested);
  LONGS_EQUAL(1, fixture.chip().state(2).level);
}

TEST(GpioTools2, GpiosetTogglesItsLines) {
  if (!tools) return;
  output_of({"gpioset", "--toggle", "1ms,1ms,0", "-c", "gpiochip0", "0=1"});
  const std::vector<int> expected{1, 0, 1};
  CHECK_EQUAL(expected, ChipFixture::levels(fixture.changes(3), 0));
}

TEST(GpioTools2, GpiomonPrintsEdgesOfSeveralLines) {
  if (!tools) return;
  auto monitor = started({"gpiomon", "--num-events=3", "--format=%E %o %S", "-c", "gpiochip0", "4", "5"});
  wait_until_requested(5, monitor);
  const MonoTime rise = now(), fall = rise + nanoseconds(1), other = rise + nanoseconds(2);
  fixture.chip().drive(4, 1, rise);
  fixture.chip().drive(4, 0, fall);
  fixture.chip().drive(5, 1, other);
  LONGS_EQUAL(0, monitor.wait(kLimit).value().code);
  const auto line = [](const std::string& edge, MonoTime time) {
    const std::string fraction = std::to_string(1'000'000'000 + to_ns(time) % 1'000'000'000).substr(1);
    return edge + " " + std::to_string(to_ns(time) / 1'000'000'000) + "." + fraction + "\n";
  };
  CHECK_EQUAL(line("rising 4", rise) + line("falling 4", fall) + line("rising 5", other), monitor.out());
}

TEST(GpioTools2, GpiomonStampsByTheClockAskedFor) {
  if (!tools) return;
  auto monitor = started({"gpiomon", "--num-events=1", "--event-clock=realtime", "--format=%S", "SENSOR_A"});
  wait_until_requested(4, monitor);
  STRCMP_CONTAINS("event-clock=realtime", output_of({"gpioinfo", "SENSOR_A"}).c_str());
  fixture.chip().drive(4, 1, now());
  LONGS_EQUAL(0, monitor.wait(kLimit).value().code);
  // Of this century's second quarter: the machine's other clock counts from its start.
  CHECK_TRUE(std::stod(monitor.out()) > 1.7e9);
}

TEST(GpioTools2, GpionotifyTellsWhatOthersDoWithALine) {
  if (!tools) return;
  auto watcher =
      started({"gpionotify", "--banner", "--num-events=4", "--format=%E %o %C", "SHUTTER", "GATE"});
  CHECK_TRUE(watcher.wait_for_out("Watching", kLimit));
  {
    auto holder = fixture.actor({"turn", "2"}, "ready", "gpio_actor_v2");
    holder.signal(SIGUSR1);
    CHECK_TRUE(holder.wait_for_out("input", kLimit));
  }
  CHECK_TRUE(said_while_the_rig_looks(watcher, "released 2"));
  const auto of_version_1 = fixture.actor({"hold", "6", "1"});
  LONGS_EQUAL(0, watcher.wait(kLimit).value().code);
  STRCMP_CONTAINS("requested 2 actor\nreconfigured 2 actor\nreleased 2 unused\nrequested 6 actor\n",
                  watcher.out().c_str());
}
