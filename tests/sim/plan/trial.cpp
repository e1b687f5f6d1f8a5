#include "tests/sim/plan/trial.hpp"

#include <cmath>
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

Trial check_plans(const RandomScene& random, std::span<const double> tolerances, int shots,
                  bool each_effect) {
  Trial trial;
  SceneBounds bounds(random.scene, random.settings);
  trial.warning = bounds.warning();
  const auto full = readouts(random, Model::full(), shots);
  for (const double tolerance : tolerances) {
    const Plan planned = plan(bounds, tolerance);
    ToleranceOutcome outcome{tolerance, planned.model, 0.0};
    const auto less = readouts(random, planned.model, shots);
    for (std::size_t i = 0; i < full.size(); ++i) {
      const PerQuantity change = difference(less[i], full[i]);
      for (std::size_t q = 0; q < reduction::kQuantityCount; ++q) {
        outcome.largest_share = std::max(outcome.largest_share, share(change[q], planned.tolerance[q]));
        if (change[q] <= planned.tolerance[q]) continue;
        trial.violations.push_back({tolerance, static_cast<int>(i) + 1, static_cast<reduction::Quantity>(q),
                                    change[q], planned.tolerance[q]});
      }
    }
    trial.tolerances.push_back(outcome);
  }
  for (std::size_t e = 0; each_effect && e < kEffectCount; ++e) {
    const auto effect = static_cast<Effect>(e);
    if (!bounds.present(effect)) continue;
    const Model without = Model::full().without(effect);
    const PerQuantity bound = bounds.of(without);
    trial.effects[e].present = true;
    const auto less = readouts(random, without, shots);
    for (std::size_t i = 0; i < full.size(); ++i) {
      const PerQuantity change = difference(less[i], full[i]);
      for (std::size_t q = 0; q < reduction::kQuantityCount; ++q) {
        if (std::isinf(bound[q])) continue;
        trial.effects[e].bounded = trial.effects[e].bounded || bound[q] > 0.0;
        // Rounding of times to nanoseconds and of the fit is no effect.
        const double rounding = 1e-7 * readout_scales(random.scene)[q];
        trial.effects[e].largest_share =
            std::max(trial.effects[e].largest_share, share(std::max(0.0, change[q] - rounding), bound[q]));
      }
    }
  }
  return trial;
}

}  // namespace strobe::sim::test
