// Whether a shot's data can prove its trouble at all. Pure functions; thread-safe.
#pragma once

#include "tests/contradictions/shot.hpp"

namespace strobe::contradictions {

/// Trouble is provable from here on: a test for just this trouble, with one false alarm in a thousand (3.3 sd), then
/// overlooks one in twenty (1.7 sd more).
inline constexpr double kProof_sd = 5.0;

/// By how many of its standard deviations the quantity that this trouble shifts is shifted, at the noise that the frame
/// states, in a test that looks for nothing else. 0 where nothing in the frame contradicts: two surface points, a wrong
/// ball without a calibrated scale. Infinite for trouble that is not a contradiction between measurements.
double proof_sd(Kind kind, const Scene& scene, const Photograph& photograph, const Disturbance& disturbance);

/// Whether what is wrong is one of fewer than four surface points, or of fewer than five images of a leg, so that it
/// cannot be singled out: then, and only then, no_redundancy tells of it.
bool among_few(Kind kind, const Photograph& photograph, const Disturbance& disturbance);

}  // namespace strobe::contradictions
