#include "sim/plan/plan.hpp"

#include <algorithm>
#include <cmath>

namespace strobe::sim {

namespace {

/// What sampled shots may change.
PerQuantity allowed_of_samples(PerQuantity tolerance) {
  for (std::size_t q = 0; q < reduction::kQuantityCount; ++q) tolerance[q] *= kSampledPart;
  return tolerance;
}

/// Whether solving the contact less finely saves anything.
bool has_mechanics(const Scene& scene, const Model& model) {
  return scene.bounce.contact == ContactLaw::ode && model.has(Effect::grip);
}

/// Takes the model with the coarsest contact that sampled shots allow, or none.
std::optional<Model> allowed_by_samples(SceneBounds& bounds, const Model& wanted, Plan& plan) {
  const PerQuantity allowed = allowed_of_samples(plan.tolerance);
  for (const double contact_tolerance : kContactLadder) {
    const bool full = contact_tolerance == kFullContactTolerance;
    if (!full && !has_mechanics(bounds.scene(), wanted)) continue;
    const Model model = wanted.with_contact_tolerance(contact_tolerance);
    const auto largest = bounds.samples().largest_change(model, allowed);
    if (!largest) continue;
    plan.sampled = SampledClaim{.share = sampled_share(), .allowed = allowed, .largest = *largest};
    return model;
  }
  return std::nullopt;
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
    if (!planned.present) result.model = result.model.without(planned.effect);
  }
  Model wanted = result.model;
  for (const Effect effect : kDecidedByBounds) {
    if (wanted.has(effect) && within(bounds.of(wanted.without(effect)), tolerance))
      wanted = wanted.without(effect);
  }
  wanted = wanted.without(Effect::pixels);
  if (const auto allowed = allowed_by_samples(bounds, wanted, result)) result.model = *allowed;
  for (PlannedEffect& planned : result.effects) planned.needed = result.model.has(planned.effect);
  result.left_out = bounds.of(result.model);
  return result;
}

Plan plan(SceneBounds& bounds, double tolerance) {
  return plan(bounds, tolerances(bounds.scene(), tolerance));
}

}  // namespace strobe::sim
