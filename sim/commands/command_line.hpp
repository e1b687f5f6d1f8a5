// Input and output that the subcommands of strobe-sim share.
#pragma once

#include <cmath>
#include <string>

#include "common/units/time.hpp"

namespace strobe::sim {

/// Prints "strobe-sim: message" on stderr and returns the status.
int report_error(const std::string& message, int status);

/// |ms| below 1e12.
inline Duration from_milliseconds(double ms) { return nanoseconds(std::llround(ms * 1e6)); }

}  // namespace strobe::sim
