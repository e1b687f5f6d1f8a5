// All states of a model that can be reached, nearest first.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "tests/stops/model.hpp"

namespace strobe::stops {

struct Found {
  std::size_t states = 0, transitions = 0, triggers = 0;
  std::size_t depth = 0;  ///< steps to the state that takes the most
  int turns = 0;          ///< the most of a host, from a person's act to the trigger
  double seconds = 0.0;
  std::string wrong;       ///< empty: nothing
  std::vector<Step> path;  ///< to it, none is shorter
};

/// Ends at the first that is wrong.
Found search(const Limits& limits, const Fault& fault = {});

std::string in_words(const Found& found);

}  // namespace strobe::stops
