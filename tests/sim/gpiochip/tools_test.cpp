// Debian 12's own GPIO programs, those of libgpiod 1, unmodified, against the simulated chip: skipped where others are
// installed. What each call answers is conformance_test.cpp's, for both versions; and the preloaded library itself.
#include <signal.h>
#include <unistd.h>

#include "tests/sim/gpiochip/fixture.hpp"
#include "tests/support/gpio_tools.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::sim;
using testing::CompletedProcess;

TEST_GROUP(GpioTools) {
  ChipFixture fixture;

  void setup() override {
    if (!testing::gpio_tools_are_of_version_2()) return;
    std::printf("skipped: the installed tools are of libgpiod 2 ");
    TEST_EXIT;
  }

  /// Fails the test with the reason if the tool is missing or failed.
  std::string output_of(std::vector<std::string> arguments) {
    const std::string tool = arguments[0];
    const CompletedProcess finished = fixture.run(std::move(arguments));
    const std::string problem = tool + " failed (is the package gpiod installed?): " + finished.err;
    CHECK_TRUE_TEXT(finished.status.has_value() && finished.status->code == 0, problem.c_str());
    return finished.out;
  }
};

TEST(GpioTools, GpiodetectListsTheChip) {
  const std::string out = output_of({"gpiodetect"});
  STRCMP_CONTAINS("gpiochip0 [strobe-sim-rig] (16 lines)\n", out.c_str());
}

TEST(GpioTools, GpioinfoShowsLinesAndOwners) {
  const auto holder = fixture.actor({"hold", "1", "1"});
  const std::string out = output_of({"gpioinfo", "gpiochip0"});
  STRCMP_CONTAINS("gpiochip0 - 16 lines:\n", out.c_str());
  STRCMP_CONTAINS("line   0:   \"STROBE_A\"       unused   input  active-high \n", out.c_str());
  STRCMP_CONTAINS("line   1:   \"STROBE_B\"      \"actor\"  output  active-high [used]\n", out.c_str());
}

TEST(GpioTools, GpiogetFindsTheChipByLabelAndPath) {
  CHECK_EQUAL("1\n", output_of({"gpioget", "strobe-sim-rig", "8"}));
  CHECK_EQUAL("1\n", output_of({"gpioget", "/dev/gpiochip0", "8"}));
  CHECK_EQUAL("1\n", output_of({"gpioget", "0", "8"}));
}

TEST(GpioTools, GpiomonPrintsEdges) {
  testing::Process monitor(
      fixture.preloaded({"gpiomon", "--num-events=2", "--format=%e %o %s.%n", "gpiochip0", "4"}),
      fixture.logs());
  CHECK_TRUE(
      testing::wait_until([&] { return fixture.chip().state(4).requested || !monitor.running(); }, kLimit));
  const MonoTime rise = now(), fall = rise + nanoseconds(1);
  fixture.chip().drive(4, 1, rise);
  fixture.chip().drive(4, 0, fall);
  LONGS_EQUAL(0, monitor.wait(kLimit).value().code);
  const auto line = [](int rising, MonoTime time) {
    return std::to_string(rising) + " 4 " + std::to_string(to_ns(time) / 1'000'000'000) + "." +
           std::to_string(to_ns(time) % 1'000'000'000) + "\n";
  };
  CHECK_EQUAL(line(1, rise) + line(0, fall), monitor.out());
}

TEST_GROUP(PreloadedLibrary) { ChipFixture fixture; };

TEST(PreloadedLibrary, DoesNothingWithoutItsVariable) {
  testing::Command command = fixture.preloaded({"gpiodetect"});
  command.environment.erase(kChipDirVariable);
  command.arguments = {"env", "-u", kChipDirVariable, "gpiodetect"};
  const CompletedProcess finished = testing::run_process(command, kLimit);
  CHECK_EQUAL("", finished.err);
  CHECK_EQUAL(std::string::npos, finished.out.find("strobe-sim-rig"));
}

TEST(PreloadedLibrary, ComplainsInOneLineWhenItsVariableIsWrong) {
  const bool v2 = testing::gpio_tools_are_of_version_2();
  testing::Command command =
      fixture.preloaded(v2 ? std::vector<std::string>{"gpioget", "-c", "gpiochip0", "0"}
                           : std::vector<std::string>{"gpioget", "gpiochip0", "0"});
  command.environment[kChipDirVariable] = "/nonexistent";
  const CompletedProcess finished = testing::run_process(command, kLimit);
  LONGS_EQUAL(1, finished.status.value().code);
  STRCMP_CONTAINS("strobe-gpiochip: STROBE_GPIOCHIP_DIR=/nonexistent: ", finished.err.c_str());
  // Never the machine's own chip.
  STRCMP_CONTAINS(v2 ? "cannot find GPIO chip" : "No such device", finished.err.c_str());
}

TEST(PreloadedLibrary, RunsBesideThreadSanitizer) {
  auto holder = fixture.actor({"toggle", "0,1", "1000", "0"}, "done", "gpio_actor_tsan");
  LONGS_EQUAL(0, holder.wait(kLimit).value().code);
  LONGS_EQUAL(2'000, fixture.changes(2'000).size());
}

TEST(PreloadedLibrary, RunsBesideAddressSanitizer) {
  const CompletedProcess finished = testing::run_process(
      fixture.preloaded({built_program("gpio_actor_asan").string(), "toggle", "0,1", "1000", "0"},
                        STROBE_ASAN_LIBRARY),
      kLimit);
  CHECK_EQUAL("", finished.err);
  LONGS_EQUAL(0, finished.status.value().code);
  LONGS_EQUAL(2'000, fixture.changes(2'000).size());
}
