// What a fit was made of: its inputs one by one, each of which can be moved. Part of the reduction, not of
// its interface. Thread-safe; allocates.
#pragma once

#include <functional>
#include <vector>

#include "common/reduction/propagate.hpp"
#include "common/reduction/uncertainty.hpp"

namespace strobe::reduction {

/// One input, independent of the others, which can be moved.
struct Input {
  std::size_t source = 0;  ///< index in Inputs::sources
  std::function<void(ShotFit&, double sds)> move;
};

/// What a fit was made of: the measurements that it used.
struct Inputs {
  ShotFit fit;  ///< its noise as if it had been stated: weights do not follow what is moved
  std::vector<BudgetSource> sources;  ///< without effects
  std::vector<Input> inputs;
};

Inputs inputs_of(const ShotFit& fit);

/// The numbers of the fit with what was moved in it.
Quantities numbers(ShotFit moved, const PropagationOptions& propagation);

}  // namespace strobe::reduction
