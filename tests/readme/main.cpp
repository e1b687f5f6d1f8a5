// Tests of the READMEs, in a network and with a key of their own.
#include <cstdio>
#include <cstdlib>

#include "tests/support/private_network.hpp"
#include "tests/support/temporary_folder.hpp"
#include <CppUTest/CommandLineTestRunner.h>

#include <CppUTest/TestHarness.h>

int main(int argc, char** argv) {
  // The commands use the default network; other tests draw theirs at random.
  if (const std::string problem = strobe::testing::enter_private_network(); !problem.empty())
    std::fprintf(stderr, "no private network (%s), going on in this one\n", problem.c_str());
  const strobe::testing::TemporaryFolder configuration;
  setenv("XDG_CONFIG_HOME", configuration.path().c_str(), 1);
  MemoryLeakWarningPlugin::turnOffNewDeleteOverloads();
  return CommandLineTestRunner::RunAllTests(argc, argv);
}
