// The system calls that a trial may let fail, and how. Pure.
#pragma once

#include <string>

namespace strobe::ends {

struct FailingCall {
  const char* name = "";
  int number = 0;
  const char* error_name = "";
  int error = 0;
  std::string words() const { return std::string(name) + " " + error_name; }
};

/// argument: 0 or more.
FailingCall failing_call(int argument);

}  // namespace strobe::ends
