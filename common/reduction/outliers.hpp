// Images that do not fit their leg. Part of the reduction, not of its interface. Thread-safe.
#pragma once

#include "common/reduction/shot_fit.hpp"

namespace strobe::reduction {

/// Marks the worst measurement as not to be used if it is further from what the others predict than chance
/// explains: one clean photograph in a thousand loses a measurement, however many images it has (Bonferroni).
/// The test is leave-one-out: chi squared where the noise is stated, F or t where it was estimated. Needs at
/// least four measurements of a kind: of three that disagree none can be singled out. Returns whether one was
/// marked; the caller fits again.
bool reject_worst_outlier(ShotFit& fit);

}  // namespace strobe::reduction
