#include "tests/sim/effects/trial.hpp"

#include <algorithm>
#include <limits>

namespace strobe::sim::test {

namespace {

constexpr std::uint64_t kSeed = 7;

std::vector<reduction::Quantities> readouts(const RandomScene& random, const Model& model, int shots) {
  std::vector<reduction::Quantities> all;
  auto shooter = Shooter::make(random.scene, kSeed, model, random.settings);
  for (int shot = 1; shooter && shot <= shots; ++shot) all.push_back(readout_of(shooter->shoot(shot).frame));
  return all;
}

double share(double difference, double allowed) {
  if (difference == 0.0) return 0.0;
  return allowed > 0.0 ? difference / allowed : std::numeric_limits<double>::infinity();
}

}  // namespace

Trial check_choices(const RandomScene& random, std::span<const double> tolerances, int shots) {
  Trial trial;
  ModelChooser chooser(random.scene, random.settings);
  const auto full = readouts(random, Model::full(), shots);
  for (const double tolerance : tolerances) {
    const ModelChoice choice = chooser.choose(tolerance);
    ToleranceOutcome outcome{choice.model, 0.0};
    const auto less = readouts(random, choice.model, shots);
    for (std::size_t i = 0; i < full.size(); ++i) {
      const PerQuantity change = difference(less[i], full[i]);
      for (std::size_t q = 0; q < reduction::kQuantityCount; ++q) {
        outcome.largest_share = std::max(outcome.largest_share, share(change[q], choice.tolerances[q]));
        if (change[q] <= choice.tolerances[q]) continue;
        trial.violations.push_back({tolerance, static_cast<int>(i) + 1, static_cast<reduction::Quantity>(q),
                                    change[q], choice.tolerances[q]});
      }
    }
    trial.tolerances.push_back(outcome);
  }
  return trial;
}

}  // namespace strobe::sim::test
