// Debian's GPIO programs: those of libgpiod 1 and 2 have the same names and other options.
#pragma once

#include <chrono>

#include "tests/support/process.hpp"

namespace strobe::testing {

/// Whether the installed ones are of version 2.
inline bool gpio_tools_are_of_version_2() {
  const CompletedProcess version =
      run_process({.arguments = {"gpiodetect", "--version"}}, std::chrono::seconds(20));
  return version.out.find(" v2.") != std::string::npos;
}

}  // namespace strobe::testing
