// How many balls the wanted uncertainty takes. Pure; thread-safe.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "host/design/prediction.hpp"
#include "host/series/wanted.hpp"

namespace strobe::host {

/// What was wanted of one quantity, in its unit, and what it takes.
struct Need {
  reduction::Quantity quantity{};
  double half_width = 0.0;  ///< of the mean's 95 % interval; of a difference its size
  bool is_difference = false;
  std::optional<int> shots;  ///< that count; of a difference, of each series; absent: no number would do
};

/// Without those that no ball can tell. `power`: of differences.
std::vector<Need> needs(const Prediction& prediction, std::span<const Wanted> wanted,
                        std::span<const Wanted> differences, double power);

}  // namespace strobe::host
