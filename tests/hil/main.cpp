// Tests of the shipped programs, in a network of their own.
#include <cstdio>
#include <string>

#include "tests/support/private_network.hpp"
// CppUTest redefines new; its headers come last.
#include <CppUTest/CommandLineTestRunner.h>

#include <CppUTest/TestHarness.h>

int main(int argc, char** argv) {
  const std::string problem = strobe::testing::enter_private_network();
  // Without a namespace each bench still has a multicast group and port drawn at random.
  if (!problem.empty())
    std::fprintf(stderr, "no private network (%s), going on in this one\n", problem.c_str());
  MemoryLeakWarningPlugin::turnOffNewDeleteOverloads();
  return CommandLineTestRunner::RunAllTests(argc, argv);
}
