// The analysis over a fixed grid of arguments, to be computed by differently compiled programs and compared.
#pragma once

#include <string>
#include <vector>

namespace strobe::numerics {

struct GridValue {
  std::string form;  ///< e.g. "pulse state, exact"
  double value = 0.0;
};

/// Always the same values in the same order; about twenty thousand.
std::vector<GridValue> fixed_grid();

}  // namespace strobe::numerics
