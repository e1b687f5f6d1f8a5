// Tests of the shipped programs, in a network and with a lab key of their own.
#include <cstdio>
#include <cstdlib>
#include <string>

#include "tests/support/private_network.hpp"
#include "tests/support/temporary_folder.hpp"

#include <CppUTest/CommandLineTestRunner.h>

#include <CppUTest/TestHarness.h>

int main(int argc, char** argv) {
  const std::string problem = strobe::testing::enter_private_network();
  // Without a namespace each network still has a multicast group and port drawn at random.
  if (!problem.empty())
    std::fprintf(stderr, "no private network (%s), going on in this one\n", problem.c_str());
  const strobe::testing::TemporaryFolder home;
  setenv("XDG_CONFIG_HOME", home.path().c_str(), 1);
  MemoryLeakWarningPlugin::turnOffNewDeleteOverloads();
  return CommandLineTestRunner::RunAllTests(argc, argv);
}
