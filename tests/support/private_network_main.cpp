// Tests of the shipped programs, in a network and with a lab key of their own.
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>

#include "tests/support/private_network.hpp"
#include "tests/support/skip.hpp"

#include <CppUTest/CommandLineTestRunner.h>
#include <CppUTest/TestHarness.h>

#ifndef STROBE_TEST_ATTEMPTS
#define STROBE_TEST_ATTEMPTS 1
#endif

namespace {

/// Where there is another attempt in a process of its own, so that it comes even if this one dies.
int run_tests(int argc, char** argv) {
  if (STROBE_TEST_ATTEMPTS == 1) return CommandLineTestRunner::RunAllTests(argc, argv);
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    std::exit(CommandLineTestRunner::RunAllTests(argc, argv));
  }
  int status = 0;
  if (child < 0 || waitpid(child, &status, 0) != child) return 1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : 1;
}

}  // namespace

int main(int argc, char** argv) {
  const strobe::testing::IsolatedEnvironment isolated;
  MemoryLeakWarningPlugin::turnOffNewDeleteOverloads();
  int failed = 1;
  for (int attempt = 0; attempt < STROBE_TEST_ATTEMPTS && failed != 0; ++attempt) {
    if (attempt > 0) std::puts("once more:");
    failed = run_tests(argc, argv);
  }
  return strobe::testing::exit_status(failed);
}
