#include "tests/support/floating_point_traps.hpp"

#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <csignal>
#include <functional>
#include <limits>

#include <CppUTest/TestHarness.h>

using strobe::testing::FloatingPointTraps;
using strobe::testing::raises_exception;

namespace {

/// The signal that ends a child which makes the call under traps, 0 if it lives.
int signal_of(const std::function<double(double)>& call, double argument) {
  const pid_t child = fork();
  if (child == 0) {
    std::signal(SIGFPE, SIG_DFL);  // not the handler of a sanitizer
    const FloatingPointTraps traps;
    volatile double result = call(argument);
    static_cast<void>(result);
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFSIGNALED(status) ? WTERMSIG(status) : 0;
}

}  // namespace

TEST_GROUP(Traps){};

TEST(Traps, CatchWhatMakesANanOrAnInfinity) {
  LONGS_EQUAL(SIGFPE, signal_of([](double x) { return std::sqrt(x); }, -1.0));
  LONGS_EQUAL(SIGFPE, signal_of([](double x) { return 1.0 / x; }, 0.0));
  LONGS_EQUAL(SIGFPE, signal_of([](double x) { return x * x; }, 1e200));
  LONGS_EQUAL(SIGFPE, signal_of([](double x) { return x - x; }, std::numeric_limits<double>::infinity()));
}

TEST(Traps, LetUnderflowAndRoundingPass) {
  LONGS_EQUAL(0, signal_of([](double x) { return x * x; }, 1e-200));
  LONGS_EQUAL(0, signal_of([](double x) { return 1.0 / x; }, 3.0));
}

TEST(Traps, EndWithTheirScope) {
  { const FloatingPointTraps traps; }
  volatile double zero = 0.0;
  volatile double quotient = 1.0 / zero;
  CHECK(std::isinf(quotient));
}

TEST(Traps, FlagsTellWhetherACallRaisedAnException) {
  volatile double zero = 0.0, result = 0.0;
  CHECK(raises_exception([&] { result = 1.0 / zero; }));
  CHECK_FALSE(raises_exception([&] { result = 1.0 / 3.0; }));
}
