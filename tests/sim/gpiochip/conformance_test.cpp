// The simulated chip's answers are those of a real kernel's driver, which tests/kernel holds to the same
// files.
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "tests/sim/gpiochip/conformance/requests.hpp"
#include "tests/sim/gpiochip/fixture.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::sim;

TEST_GROUP(Conformance) {
  ChipFixture fixture;

  void do_as_asked(const testing::conformance::Request& request) {
    const std::uint32_t line = request.line == 'B' ? 11 : 12;
    for (int i = 0; i < request.times; ++i)
      for (const int level : request.levels) fixture.chip().drive(line, level, now());
    if (request.unplug) fixture.chip().unplug();
  }

  /// As a rig does all the time.
  void look() {
    ChangeCursor cursor = fixture.chip().cursor_now();
    std::vector<Change> changes;
    fixture.chip().wait_changes(cursor, now(), changes);
  }

  /// What a program prints that asks for what must happen outside; `chip`: as it wants it named.
  std::string answers_to(const std::filesystem::path& program, const std::vector<std::string>& chip) {
    const std::string answers = fixture.logs() / "answers";
    LONGS_EQUAL(0, mkfifo(answers.c_str(), 0600));
    std::vector<std::string> words{program.string()};
    words.insert(words.end(), chip.begin(), chip.end());
    words.insert(words.end(), {"10", "11", "12", answers});
    testing::Process process(fixture.preloaded(words), fixture.logs());
    std::size_t done = 0;
    CHECK_TRUE(testing::wait_until(
        [&] {
          const auto requests = testing::conformance::requests_in(process.out());
          if (requests.size() > done) {
            do_as_asked(requests[done++]);
            close(open(answers.c_str(), O_WRONLY));
          }
          look();
          return !process.running();
        },
        kLimit));
    CHECK_EQUAL("", process.err());
    return process.out();
  }
};

TEST(Conformance, SystemCallsAreAnsweredAsByTheKernel) {
  const testing::CompletedProcess finished =
      fixture.run({built_program("gpio_kernel_calls").string(), "/dev/gpiochip0", "10", "11"});
  LONGS_EQUAL(0, finished.status.value().code);
  CHECK_EQUAL(testing::read_text(STROBE_TEST_DATA "/gpio_kernel_calls.txt"), finished.out);
}

TEST(Conformance, SystemCallsOfVersion2AreAnsweredAsByTheKernel) {
  const std::string out = answers_to(built_program("gpio_kernel_calls_v2"), {"/dev/gpiochip0"});
  CHECK_EQUAL(testing::read_text(STROBE_TEST_DATA "/gpio_kernel_calls_v2.txt"), out);
}

TEST(Conformance, TheFirmwaresGpioChipIsAnsweredAsByTheKernel) {
  const std::string out = answers_to(built_program("gpio_chip_calls"), {"gpiochip0", "strobe-sim-rig"});
  CHECK_EQUAL(testing::read_text(STROBE_TEST_DATA "/gpio_chip_calls.txt"), out);
}

#ifdef STROBE_GPIOD2_PROGRAMS
TEST(Conformance, TheFirmwaresGpioChipIsAnsweredAsByTheKernelWithLibgpiod2Too) {
  const std::string out =
      answers_to(STROBE_GPIOD2_PROGRAMS "/gpio_chip_calls", {"gpiochip0", "strobe-sim-rig"});
  CHECK_EQUAL(testing::read_text(STROBE_TEST_DATA "/gpio_chip_calls.txt"), out);
}
#endif
