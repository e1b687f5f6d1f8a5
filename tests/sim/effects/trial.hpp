// The models that one scene allows put to the test: shots by the chosen and by the full model, with the same seed.
#pragma once

#include <span>
#include <vector>

#include "sim/effects/choice.hpp"
#include "tests/sim/effects/random_scene.hpp"

namespace strobe::sim::test {

/// Where a number of a shot by the chosen model differs by more than the tolerance.
struct Violation {
  double tolerance = 0.0;
  int shot = 0;
  reduction::Quantity quantity = reduction::Quantity::vx_td_mps;
  double difference = 0.0, allowed = 0.0;
};

struct ToleranceOutcome {
  Model model = Model::full();
  double largest_share = 0.0;  ///< of the tolerance, over shots and numbers
};

struct Trial {
  std::vector<ToleranceOutcome> tolerances;
  std::vector<Violation> violations;
};

/// `shots` shots of the scene for each tolerance, by a seed that no choice knows.
Trial check_choices(const RandomScene& random, std::span<const double> tolerances, int shots);

}  // namespace strobe::sim::test
