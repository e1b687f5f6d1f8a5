// Which effects a simulation of a scene has to compute, so that every number read from every shot stays
// within a tolerance of what it would be with all of them.
//
// What is decided. An effect that costs next to nothing is always on (kDecided lists the others): leaving it out would
// only add to the error. Decided are the effects of kDecided and how exactly the contact is solved (kContactLadder).
//
// How. Those of kDecidedByBounds are tried in its order: one is left out if for every quantity the bound of all that is
// then left out together (scene_bounds.hpp) is within the quantity's tolerance. Then the pixels are left out and the
// contact's tolerance is loosened as far as kSampledShots simulated shots, everything together, change no number by more
// than kSampledPart of its tolerance (sampled_shots.hpp). If they do even with the contact as in the full model, nothing
// is left out; where pixels are kept they are all that costs. The order is fixed, since a choice must not depend on how
// busy a machine is; what is saved is measured (cost.hpp). Deterministic; allocates.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "sim/plan/readouts.hpp"
#include "sim/plan/scene_bounds.hpp"
#include "sim/scene/model.hpp"

namespace strobe::sim {

/// The effects that cost something, the most expensive first.
inline constexpr std::array kDecided{Effect::pixels, Effect::contact_ode, Effect::flash_duration};
inline constexpr std::array kDecidedByBounds{Effect::contact_ode, Effect::flash_duration};

constexpr bool is_decided(Effect effect) {
  for (const Effect e : kDecided)
    if (e == effect) return true;
  return false;
}

/// Tolerances of the contact, coarsest first.
inline constexpr std::array kContactLadder{1e-3, 1e-4, 1e-5, 1e-6, kFullContactTolerance};
static_assert(kContactLadder.size() <= kCandidates);

/// Part of the tolerance that sampled shots may change a number by.
inline constexpr double kSampledPart = 0.5;

struct PlannedEffect {
  Effect effect = Effect::gravity;
  bool present = false;  ///< the scene has it
  bool needed = false;   ///< it is simulated
  PerQuantity bound;     ///< of leaving it out alone, in the quantities' units
  /// The quantity whose bound takes most of its tolerance.
  reduction::Quantity worst = reduction::Quantity::vx_td_mps;
};

/// What the sampled shots say of everything that is left out.
struct SampledClaim {
  int shots = kSampledShots;
  double share = 0.0;  ///< fewer shots than this change some number by more than `allowed`, with kConfidence
  PerQuantity allowed;
  PerQuantity largest;  ///< change seen
};

struct Plan {
  Model model = Model::full();
  PerQuantity tolerance;
  PerQuantity scale;            ///< what a relative tolerance of 1 means
  PerQuantity threshold_steps;  ///< of images that appear or disappear
  PerQuantity left_out;         ///< bound of all effects left out together; pixels': see `sampled`
  std::array<PlannedEffect, kEffectCount> effects;  ///< in the order of Effect
  std::optional<SampledClaim> sampled;              ///< absent where nothing is left out
  std::string warning;  ///< why no effect that displaces an image may be left out; usually empty
};

/// The quantity whose bound takes most of its tolerance; the first of all if no bound is above 0.
reduction::Quantity worst(const PerQuantity& bound, const PerQuantity& tolerance);

/// A plan for tolerances in the quantities' units.
Plan plan(SceneBounds& bounds, const PerQuantity& tolerance);

/// A plan for a relative tolerance, the scene's own [readout] overriding it (readouts.hpp).
Plan plan(SceneBounds& bounds, double tolerance);

}  // namespace strobe::sim
