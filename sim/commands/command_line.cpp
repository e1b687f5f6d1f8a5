#include "sim/commands/command_line.hpp"

#include <fmt/format.h>

#include <cstdio>

namespace strobe::sim {

int report_error(const std::string& message, int status) {
  fmt::print(stderr, "strobe-sim: {}\n", message);
  return status;
}

}  // namespace strobe::sim
