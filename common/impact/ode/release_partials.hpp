// A contact's state at release and its derivatives with respect to the dimensionless inputs of contact_system.hpp: by the
// variational equations of the collocation, or by differences of the integrator. Pure, no allocation: thread-safe,
// real-time safe.
#pragma once

#include "common/impact/ode/segment_partials.hpp"

namespace strobe::impact::detail {

/// As changes since touchdown; the rate is that of the depth.
struct ReleaseState {
  double tau = 0.0, rate = 0.0, vx = 0.0, spin = 0.0, path = 0.0, angle = 0.0;
};

struct ReleasePartials {
  ContactLiftOff contact;
  ReleaseState state;
  Partials tau{}, rate{}, vx{}, spin{}, path{}, angle{};
};

/// Errors as for lift_off().
tl::expected<ReleasePartials, InputError> release_partials(const System& system,
                                                           const ContactOptions& options);

/// Of the spring that a restitution and a dwell time give: derivatives of zeta and of the logarithm of the release's
/// phase, which is sqrt(k/m) times the dwell time, with respect to e.
struct SpringPartials {
  double zeta_by_e, phase_by_e;
};
SpringPartials spring_partials(const System& system);

}  // namespace strobe::impact::detail
