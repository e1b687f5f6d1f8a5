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

/// The first step that should have found the fault and did; empty: none.
std::string found_by(const WrongRig& rig, const Outcome& outcome);

}  // namespace strobe::commission_bench
