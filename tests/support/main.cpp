#include <CppUTest/CommandLineTestRunner.h>

#include <CppUTest/TestHarness.h>

int main(int argc, char** argv) {
  // Libraries keep lazily made statics (locales, RNG tables); leaks are the sanitizer builds' business.
  MemoryLeakWarningPlugin::turnOffNewDeleteOverloads();
  return CommandLineTestRunner::RunAllTests(argc, argv);
}
