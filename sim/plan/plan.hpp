// Which effects a simulation of a scene has to compute, so that every number read from every shot stays
// within a tolerance of what it would be with all of them.
//
// The choice. Effects whose bound is zero, the scene's parameters being what they are, are left out at once.
// The others are tried in the order of kByCost, most expensive first: one is left out if for every quantity
// the bound of all that is then left out together (scene_bounds.hpp) is within the quantity's tolerance. The
// order is fixed, since a choice must not depend on how busy a machine is; what is saved is measured
// (cost.hpp). Deterministic; allocates.
#pragma once

#include <array>
#include <string>

#include "sim/plan/readouts.hpp"
#include "sim/plan/scene_bounds.hpp"
#include "sim/scene/model.hpp"

namespace strobe::sim {

/// Effects by the extra cost of a shot with them, the most expensive first, measured on the thesis's scenes,
/// a court pace shot and a photograph of pixels.
inline constexpr std::array<Effect, kEffectCount> kByCost{Effect::pixels,
                                                          Effect::contact_ode,
                                                          Effect::tangential_compliance,
                                                          Effect::drag,
                                                          Effect::magnus,
                                                          Effect::spin_decay,
                                                          Effect::lamp_jitter,
                                                          Effect::sensor_delay,
                                                          Effect::perspective,
                                                          Effect::lens_distortion,
                                                          Effect::flash_duration,
                                                          Effect::gravity,
                                                          Effect::contact_gravity,
                                                          Effect::offset,
                                                          Effect::grip,
                                                          Effect::shutter_lag,
                                                          Effect::lamp_delay};

struct PlannedEffect {
  Effect effect = Effect::gravity;
  bool present = false;  ///< the scene has it
  bool needed = false;
  PerQuantity bound;  ///< of leaving it out alone, in the quantities' units
  /// The quantity whose bound takes most of its tolerance.
  reduction::Quantity worst = reduction::Quantity::vx_td_mps;
};

struct Plan {
  Model model = Model::full();
  PerQuantity tolerance;
  PerQuantity scale;                                ///< what a relative tolerance of 1 means
  PerQuantity threshold_steps;                      ///< of images that appear or disappear
  PerQuantity left_out;                             ///< bound of all effects left out together
  std::array<PlannedEffect, kEffectCount> effects;  ///< in the order of Effect
  std::string warning;  ///< why no effect that displaces an image may be left out; usually empty
};

/// The quantity whose bound takes most of its tolerance; the first of all if no bound is above 0.
reduction::Quantity worst(const PerQuantity& bound, const PerQuantity& tolerance);

/// A plan for tolerances in the quantities' units.
Plan plan(SceneBounds& bounds, const PerQuantity& tolerance);

/// A plan for a relative tolerance, the scene's own [readout] overriding it (readouts.hpp).
Plan plan(SceneBounds& bounds, double tolerance);

}  // namespace strobe::sim
