#include "sim/plan/plan.hpp"

#include <algorithm>

namespace strobe::sim {

namespace {

bool within(const PerQuantity& bound, const PerQuantity& tolerance) {
  for (std::size_t q = 0; q < reduction::kQuantityCount; ++q) {
    if (!(bound[q] <= tolerance[q])) return false;
  }
  return true;
}

}  // namespace

reduction::Quantity worst(const PerQuantity& bound, const PerQuantity& tolerance) {
  std::size_t result = 0;
  double largest = -1.0;
  for (std::size_t q = 0; q < reduction::kQuantityCount; ++q) {
    const double share = bound[q] > 0.0 ? bound[q] / tolerance[q] : 0.0;
    if (!(share > largest)) continue;  // infinite of infinite is none
    largest = share;
    result = q;
  }
  return static_cast<reduction::Quantity>(result);
}

Plan plan(SceneBounds& bounds, const PerQuantity& tolerance) {
  Plan result;
  result.tolerance = tolerance;
  result.scale = readout_scales(bounds.scene());
  result.threshold_steps = bounds.threshold_steps();
  result.warning = bounds.warning();
  for (std::size_t i = 0; i < kEffectCount; ++i) {
    PlannedEffect& planned = result.effects[i];
    planned.effect = static_cast<Effect>(i);
    planned.present = bounds.present(planned.effect);
    if (planned.present) planned.bound = bounds.of(planned.effect);
    planned.worst = worst(planned.bound, tolerance);
    if (planned.bound.all_zero()) result.model = result.model.without(planned.effect);
  }
  for (const Effect effect : kByCost) {
    if (!result.model.has(effect)) continue;
    const Model without = result.model.without(effect);
    if (within(bounds.of(without), tolerance)) result.model = without;
  }
  for (PlannedEffect& planned : result.effects) planned.needed = result.model.has(planned.effect);
  result.left_out = bounds.of(result.model);
  return result;
}

Plan plan(SceneBounds& bounds, double tolerance) {
  return plan(bounds, tolerances(bounds.scene(), tolerance));
}

}  // namespace strobe::sim
