// One scene's plans put to the test: shots by the planned and by the full model, with the same seed.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "sim/plan/plan.hpp"
#include "tests/sim/plan/random_scene.hpp"

namespace strobe::sim::test {

/// Where a planned shot's number differs by more than the tolerance.
struct Violation {
  double tolerance = 0.0;
  int shot = 0;
  reduction::Quantity quantity = reduction::Quantity::vx_td_mps;
  double difference = 0.0, allowed = 0.0;
};

struct ToleranceOutcome {
  double tolerance = 0.0;
  Model model = Model::full();
  double largest_share = 0.0;  ///< of the tolerance, over shots and numbers
};

/// Observed change over its bound, for an effect left out alone.
struct EffectOutcome {
  bool present = false;
  bool bounded = false;  ///< the bound is neither 0 nor infinite
  double largest_share = 0.0;
};

struct Trial {
  std::vector<ToleranceOutcome> tolerances;
  std::array<EffectOutcome, kEffectCount> effects{};
  std::vector<Violation> violations;
  std::string warning;
};

/// `shots` shots of the scene for each tolerance; of each effect alone as well if `each_effect`.
Trial check_plans(const RandomScene& random, std::span<const double> tolerances, int shots, bool each_effect);

}  // namespace strobe::sim::test
