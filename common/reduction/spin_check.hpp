// Whether the spins before and after the bounce can belong together. Part of the reduction, not of its
// interface. Pure; thread-safe.
#pragma once

#include "common/reduction/readout.hpp"
#include "common/reduction/shot_fit.hpp"

namespace strobe::reduction {

/// Friction turns the ball by as much as it takes from its travel: alpha·R·(omega_LO - omega_TD) =
/// vx_LO - vx_TD (thesis, eq. 9 to 12). A spin that was read modulo half a turn between images is wrong by
/// pi/T or a multiple of it, T being the interval. True where the two spins contradict friction by more than
/// half of that: one of them then turned by more than a quarter turn between images, which the angles
/// themselves cannot show. What alpha (0.55 or 2/3), the offset of the normal force and noise can make of
/// the difference is some 200 rad/s at 20 m/s, in proportion to the speed, less than half of pi/T for any T
/// below 7 ms; false for longer intervals. Where images of one leg are lacking, so that its T is
/// longer than the other's, spins are to be expected that it cannot tell: there it is enough that a spin read
/// wrong could hide behind an offset d of half a radius, d·J/(alpha·R²). False where a number is lacking.
bool spins_contradict_friction(const Readout& readout, const ShotFit& fit);

}  // namespace strobe::reduction
