// Rigs with one fault each, and which step of commissioning should find it.
#pragma once

#include <string>
#include <vector>

#include "tests/commission/commission_bench.hpp"

namespace strobe::commission_bench {

struct WrongRig {
  std::string name;
  BenchOptions options;
  std::vector<std::string> found_by;  ///< any of these steps must fail
};

const std::vector<WrongRig>& wrong_rigs();

}  // namespace strobe::commission_bench
