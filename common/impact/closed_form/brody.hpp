// The two rigid-body models of a bounce (H. Brody, That's how the ball bounces, 1984; thesis eq. 9-16) one by
// one, to compare each with measurements: a ball that slides throughout, one that rolls off, and the
// criterion that selects one of them. rigid() of rebound.hpp does all in one call. Conventions and units as
// in rebound.hpp. Pure, no allocation: thread-safe, real-time safe.
#pragma once

#include <tl/expected.hpp>

#include "common/impact/closed_form/rebound.hpp"

namespace strobe::impact {

/// Friction at its limit mu·J throughout (eq. 9-12 for any alpha), against the slip at touchdown. Where the
/// contact point would have stopped before lift-off the result slips the other way, which friction cannot do.
/// Without slip there is no friction. Errors as for rigid().
tl::expected<Rebound, InputError> slide(const ball::Ball& ball, const Motion& touchdown, double e, double mu);

/// Rolls at lift-off, whatever friction that needs: vx_LO = (vx - alpha·R·omega)/(1 + alpha) (eq. 14, 15 for
/// any alpha). Errors as for rigid().
tl::expected<Rebound, InputError> roll(const ball::Ball& ball, const Motion& touchdown, double e);

struct SlideOrRoll {
  Rebound rebound;                     ///< slide() or roll()
  double rolling_impulse_ratio = 0.0;  ///< |s|·alpha/((1 + alpha)·J), which rolling off needs
};

/// The criterion after eq. 16a, corrected for signed slip: slides throughout iff mu is less than rolling off
/// needs.
tl::expected<SlideOrRoll, InputError> slide_or_roll(const ball::Ball& ball, const Motion& touchdown, double e,
                                                    double mu);

}  // namespace strobe::impact
