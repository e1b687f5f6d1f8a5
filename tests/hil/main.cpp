// Tests of the shipped programs, in a network of their own.
#include <cstdio>
#include <cstdlib>
#include <string>

#include "tests/support/private_network.hpp"
#include "tests/support/temporary_folder.hpp"

#include <CppUTest/CommandLineTestRunner.h>

#include <CppUTest/TestHarness.h>

int main(int argc, char** argv) {
  const std::string problem = strobe::testing::enter_private_network();
  // Without a namespace each bench still has a multicast group and port drawn at random.
  if (!problem.empty())
    std::fprintf(stderr, "no private network (%s), going on in this one\n", problem.c_str());
  // A key of the tests' own, which their first program makes, instead of this user's.
  const strobe::testing::TemporaryFolder configuration;
  setenv("XDG_CONFIG_HOME", configuration.path().c_str(), 1);
  MemoryLeakWarningPlugin::turnOffNewDeleteOverloads();
  return CommandLineTestRunner::RunAllTests(argc, argv);
}
