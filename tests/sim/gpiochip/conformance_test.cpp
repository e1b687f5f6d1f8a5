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

  void do_as_asked(const testing::conformance::Request& request, std::uint32_t line) {
    for (const int level : request.levels) fixture.chip().drive(line, level, now());
    if (request.unplug) fixture.chip().unplug();
  }
};

TEST(Conformance, SystemCallsAreAnsweredAsByTheKernel) {
  const testing::CompletedProcess finished =
      fixture.run({built_program("gpio_kernel_calls").string(), "/dev/gpiochip0", "10", "11"});
  LONGS_EQUAL(0, finished.status.value().code);
  CHECK_EQUAL(testing::read_text(STROBE_TEST_DATA "/gpio_kernel_calls.txt"), finished.out);
}

TEST(Conformance, LibgpiodIsAnsweredAsByTheKernel) {
  const std::string answers = fixture.logs() / "answers";
  LONGS_EQUAL(0, mkfifo(answers.c_str(), 0600));
  testing::Process process(fixture.preloaded({built_program("gpio_library_calls").string(), "gpiochip0", "10",
                                              "11", "12", answers}),
                           fixture.logs());
  std::size_t done = 0;
  CHECK_TRUE(testing::wait_until(
      [&] {
        const auto requests = testing::conformance::requests_in(process.out());
        if (requests.size() > done) {
          do_as_asked(requests[done++], 12);
          close(open(answers.c_str(), O_WRONLY));
        }
        return !process.running();
      },
      kLimit));
  CHECK_EQUAL("", process.err());
  CHECK_EQUAL(testing::read_text(STROBE_TEST_DATA "/gpio_library_calls.txt"), process.out());
}
