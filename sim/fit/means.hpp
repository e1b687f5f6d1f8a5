// Coefficients with which a ball without spread rebounds with a condition's means, as closely as the
// contact's mechanics allow. Implementation of fit.hpp, which gives the derivation. Pure; thread-safe;
// allocates.
#pragma once

#include "common/data/thesis_data.hpp"
#include "common/result.hpp"
#include "sim/motion/contact_path.hpp"
#include "sim/scene/scene.hpp"

namespace strobe::sim {

/// Lift-off of the scene's mean ball.
Result<LiftOff> mean_lift_off(const Scene& scene);

/// Sets e, dwell time, mu, stiffness_ratio, damping_ratio and offset_share of a scene whose machine throws as
/// the condition's balls came in. Fails if the condition is outside the contact's ranges.
Result<void> fit_coefficients(Scene& scene, const thesis::Condition& condition);

}  // namespace strobe::sim
