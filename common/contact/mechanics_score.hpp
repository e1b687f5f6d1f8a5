// The contact's mechanics (impact/ode/contact_ode.hpp) held against the images of a set. Pure; thread-safe;
// allocates.
#pragma once

#include "common/contact/integration/integration.hpp"
#include "common/impact/ode/contact_trajectory.hpp"

namespace strobe::contact {

/// By time fraction of the mechanics' own dwell time. Images outside of 0…1 are held against its ends.
Trajectory trajectory_of(const impact::ContactTrajectory& course);

struct MechanicsScore {
  Score score;
  impact::ContactSummary summary;
};

/// Fails as score(), and on inputs that simulate() refuses.
Result<MechanicsScore> score_mechanics(const ContactSet& set, const ball::Ball& ball,
                                       const impact::Motion& touchdown,
                                       const impact::ContactCoefficients& coefficients,
                                       const SetScale& scale);

}  // namespace strobe::contact
