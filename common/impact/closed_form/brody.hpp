// The rigid-body models of a bounce apart and the choice between them (Brody; thesis eq. 9-16), to compare
// each with measurements: a ball that slides throughout, one that rolls off, and the rule that tells which.
// rigid() of rebound.hpp is the choice in one call. Conventions and units as in rebound.hpp. Pure, no
// allocation: thread-safe, real-time safe.
#pragma once

#include <tl/expected.hpp>

#include "common/impact/closed_form/rebound.hpp"

namespace strobe::impact {

/// Friction at its limit mu·J to the end (eq. 9-12 for any alpha), against the slip at touchdown. Also where
/// the contact point would have stopped before: the lift-off then slips the other way, which no friction can
/// do. Without slip there is no friction. Errors as for rigid().
tl::expected<Rebound, InputError> slide(const ball::Ball& ball, const Motion& touchdown, double e, double mu);

/// Rolls at lift-off, whatever friction that takes: vx_LO = (vx - alpha·R·omega)/(1 + alpha) (eq. 14, 15 for
/// any alpha). Errors as for rigid().
tl::expected<Rebound, InputError> roll(const ball::Ball& ball, const Motion& touchdown, double e);

/// The rule after eq. 16a, put right for signed slip: slides throughout iff the friction that rolling off
/// needs is more than there is.
struct Brody {
  Rebound rebound;               ///< slide() or roll(), whichever the rule chooses
  double friction_needed = 0.0;  ///< impulse ratio |s|·alpha/((1 + alpha)·J) that rolling off needs
};

tl::expected<Brody, InputError> choose(const ball::Ball& ball, const Motion& touchdown, double e, double mu);

}  // namespace strobe::impact
