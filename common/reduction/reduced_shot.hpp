// A readout with the fit that it is from. Part of the reduction, not of its interface. Thread-safe;
// allocates.
#pragma once

#include <optional>

#include "common/reduction/readout.hpp"
#include "common/reduction/reduce.hpp"
#include "common/reduction/shot_fit.hpp"
#include "common/result.hpp"

namespace strobe::reduction {

struct ReducedShot {
  Readout readout;
  std::optional<ShotFit> fit;     ///< absent: the frame has no surface line
  std::optional<Frame> in_plane;  ///< what was fitted instead of the frame, see spatial.hpp
};

/// As reduce(), which see; not for the legacy estimator, which fits nothing.
Result<ReducedShot> reduce_shot(const Frame& frame, Estimator estimator, const ReduceOptions& options = {});

}  // namespace strobe::reduction
