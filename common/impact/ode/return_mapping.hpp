// Lift-off of the contact of contact_ode.hpp by return mapping: a fixed number of equal steps in which the tangential
// spring is first held ("elastic predictor") and its impulse then returned to the limit that friction sets ("return").
// No events are located and nothing is iterated, so that a contact takes the same few tenths of a microsecond always.
//
// The normal motion is the damped sine in closed form, its impulse in a step exact. Holding, stretch and slip of a step
// follow in closed form from the spring, the dashpot and the impulse of the offset's couple, which is taken at the
// step's middle with the spin extrapolated from the step before; slipping, the stretch is that of a spring and dashpot
// under a force that changes linearly. Of second order where the mode stays; a change of mode is missed by up to a
// step. Over the practical range (tests/studies/trade) the worst errors are some 3 % of the speed with 8 steps, .7 %
// with 16, .15 % with 32, .05 % with 64. Energy may grow by as much.
//
// A mirrored contact is the mirror image to the last bit. No allocation; thread-safe, real-time safe.
// Source: J. C. Simo, T. J. R. Hughes, Computational Inelasticity, 1998, ch. 1.4 (return mapping; friction is its
// perfectly plastic slider).
#pragma once

#include "common/impact/ode/contact_ode.hpp"

namespace strobe::impact {

inline constexpr int kMinReturnMappingSteps = 2, kMaxReturnMappingSteps = 1'000'000;

/// The regime is as in ContactSummary, as far as the steps see it. Errors: those of simulate();
/// tolerance_out_of_range for a number of steps beyond the limits above. Where the weight is so large a part of
/// the force that its closed form does not hold, the result is simulate()'s.
tl::expected<Rebound, InputError> return_mapping(const ball::Ball& ball, const Motion& touchdown,
                                                 const ContactCoefficients& coefficients, int steps);

}  // namespace strobe::impact
