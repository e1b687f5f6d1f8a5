// The constants that the in/out models take from the contact's mechanics. Deterministic; thread-safe.
#pragma once

#include <vector>

#include "tests/studies/trade/impact_scenes.hpp"

namespace strobe::studies::trade {

/// A contact's scene with the velocities at lift-off that its mechanics give.
struct KnownImpact {
  ImpactScene scene;
  impact::Motion lift_off;
};

/// What grip() adds to the e and mu of a scene.
struct Grip {
  double e_x = 0.0, offset_m = 0.0, mu_factor = 1.0;
};

impact::Coefficients coefficients(const ImpactScene& scene, const Grip& grip);

/// |difference of the lift-offs| over the speed of touchdown, spin as R omega.
double lift_off_error(const ImpactScene& scene, const impact::Motion& got, const impact::Motion& want);

/// One e_x (and, if asked for, one offset) for all scenes: least rms of lift_off_error, by golden sections in
/// each constant in turn.
Grip calibrated_over(const std::vector<KnownImpact>& known, bool with_offset);

/// From one run of the mechanics: e_x from the slips of touchdown and lift-off, the offset from its mean over
/// the impulse, where the ball slides also mu from the impulse ratio (the tangential spring takes it a moment
/// to reach the limit).
Grip calibrated_at(const ImpactScene& scene);

// Lift-offs of contacts in 34 digits (Boost.Multiprecision, Boost.odeint). Allocates, runs threads.

/// The scenes with their lift-off.
std::vector<KnownImpact> known_impacts(const std::vector<ImpactScene>& scenes);

/// The reference's own error as lift_off_error: its change with half the step, largest of the first `most`
/// scenes.
double reference_error(const std::vector<ImpactScene>& scenes, std::size_t most);

}  // namespace strobe::studies::trade
