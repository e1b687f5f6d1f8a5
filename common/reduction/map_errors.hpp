// What the errors of the camera's map do to a readout. Part of the reduction, not of its interface. Thread-safe;
// allocates.
#pragma once

#include "common/reduction/propagate.hpp"
#include "common/reduction/readout.hpp"
#include "common/reduction/shot_fit.hpp"

namespace strobe::reduction {

/// Adds their part to sd and covariance. They move all images together, which independent noise of the images would not
/// show: the shot is fitted once more for each error, with the same measurements in use.
void add_map_errors(const ShotFit& fit, const PropagationOptions& options, const Crossings& crossings,
                    Readout& readout);

}  // namespace strobe::reduction
