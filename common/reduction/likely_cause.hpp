// Which one thing that a photograph was said to have been taken with explains why its measurements contradict
// each other. Part of the reduction, not of its interface. Thread-safe; allocates.
#pragma once

#include <optional>

#include "common/reduction/readout.hpp"
#include "common/reduction/shot_fit.hpp"
#include "common/reduction/witnesses.hpp"

namespace strobe::reduction {

/// `fit`: of all images, none left out. Fits it again with one more unknown, for each cause in turn, which is
/// named if with it
///  - the misfit (chi squared) falls by more than chance lets it in one photograph of ten thousand,
///  - no check of the measurements' consistency fails any longer, and
///  - no other cause, nor one bad image, makes the misfit as small, within 3 sd.
/// Returns nullopt otherwise, and where noise is estimated from the residuals, which then cannot exceed it.
/// Source: likelihood ratio, e.g. Koch, Parameter Estimation and Hypothesis Testing, 4.2.
std::optional<LikelyCause> likely_cause(const ShotFit& fit);

/// Gravity's magnitude as the free fall of all legs tells it, with drag and lift as far as they are known, on
/// the calibrated scale as it stands, so that the diameters have no part in it. [m/s^2] Returns nullopt where
/// the paths do not tell it.
std::optional<Estimate> local_gravity(ShotFit fit);

}  // namespace strobe::reduction
