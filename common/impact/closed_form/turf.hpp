// Rebound of a golf ball from turf: the ball is rigid beside ground that yields and meets the front of its
// own pit, as if on a rigid plane that tilts against it by
//   beta = 15.4°·(v/18.6 m/s)·(theta/44.4°),  v the speed, theta the angle of its path to the normal.
// Only such ground calls for it: elsewhere beta is 0, and rigid(), grip() or elastic_rebound() hold.
// Valid: golf balls on greens and fairways, near the 18.6 m/s and 44.4° of the limited data behind it;
// extrapolated to twice that at most. Pure, no allocation: thread-safe, real-time safe. Source: A. R. Penner,
// The run of a golf ball, Can. J. Phys. 80 (2002), which could not be read; its formula as others quote it
// (S. W. Biber et al., Sports Engineering 26 (2023), call it empirical, and linear in speed and angle).
#pragma once

#include <tl/expected.hpp>

#include "common/impact/closed_form/rebound.hpp"

namespace strobe::impact {

/// beta of a ball that moves towards +x; of one to -x its negative. 0 straight down.
double contact_plane_tilt_rad(const Motion& touchdown);

/// rigid() on the tilted plane. e is that of the level, -vy_LO/vy_TD, which the restitution on the tilted
/// plane is solved for. Errors: those of rigid(); restitution_out_of_range where no restitution on the tilted
/// plane gives e.
tl::expected<Rebound, InputError> rigid_on_turf(const ball::Ball& ball, const Motion& touchdown, double e,
                                                double mu);

}  // namespace strobe::impact
