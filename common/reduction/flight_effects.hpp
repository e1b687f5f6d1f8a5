// How much drag and lift change a readout, and which of them must be fitted. Part of the reduction, not of
// its interface. Pure functions; thread-safe.
#pragma once

#include "common/reduction/propagate.hpp"

namespace strobe::reduction {

/// Upper bound of each number's change if an acceleration is left out of the fit; absent where the number is.
///
/// Let T be the time from a leg's crossing to its farthest image and a the acceleration. A least squares line
/// through a tau^2 / 2 meets that curve between its first and last image at least twice (its residuals are
/// orthogonal to 1 and tau), so it is the chord through two instants tau1, tau2 <= T: its slope at the
/// crossing is wrong by a (tau1 + tau2) / 2 <= a T, its place by a tau1 tau2 / 2 <= a T^2 / 2. The rest is
/// how each number follows from velocities and places.
Quantities change_bound(const Readout& readout, const ShotFit& fit, const Crossings& crossings,
                        const std::array<double, 2>& acceleration_mps2);

/// `candidates` without those of drag and Magnus whose bound is below kNegligibleShareOfSd of the statistical
/// sd of every number. An effect stays if a number has no sd. Without regard to whether the fit could have it
/// (JointFit::air_used).
flight::Effects significant_effects(const Readout& readout, const ShotFit& fit, const Crossings& crossings,
                                    flight::Effects candidates);

/// A twentieth of an sd in the value moves an interval of one sd by an eight-hundredth of its coverage.
inline constexpr double kNegligibleShareOfSd = 0.05;

}  // namespace strobe::reduction
