// Whole simulated shots of a predicted condition: the rig throws, bounces by the prediction's contact,
// flashes and digitizes; the frames are reduced like any others. Deterministic from the seed; thread-safe;
// allocates.
#pragma once

#include <cstdint>

#include "common/reduction/readout.hpp"
#include "tests/studies/thesis/prediction.hpp"

namespace strobe::studies {

struct ShotSeries {
  reduction::Quantities mean;  ///< of the readouts that have the number
  reduction::Quantities sd;    ///< population sd of them
  int shots = 0;
  int without_readout = 0;  ///< no ball, or a frame that cannot be reduced
};

/// As in the thesis: machine's spread and tablet's noise fitted to the condition, 3 ms between flashes;
/// reduced by the best estimator. One shot without spread and noise if `exact`. Fails for a condition that no
/// scene can be fitted to.
Result<ShotSeries> shoot_series(const thesis::Condition& condition, const Prediction& prediction, int shots,
                                std::uint64_t seed, bool exact);

}  // namespace strobe::studies
