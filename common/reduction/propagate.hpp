// From fitted unknowns to the readout's numbers and their standard deviations.
// Part of the reduction, not of its interface. Thread-safe.
#pragma once

#include <array>
#include <optional>

#include "common/reduction/readout.hpp"
#include "common/reduction/shot_fit.hpp"

namespace strobe::reduction {

struct PropagationOptions {
  std::optional<double> temperature_c;  ///< for the court pace
  bool covariance = false;              ///< fill Readout::covariance
  bool by_time = false;                 ///< fill Readout::by_time
};

/// Touchdown and lift-off, where there is one, in the observations' time. [s]
using Crossings = std::array<std::optional<double>, 2>;

/// Fills value, sd, sd_systematic, regime and court pace, and sets too_few_images and degenerate_geometry.
/// Touchdown and lift-off are where the fitted flight has its centre one radius above the fitted line. Every
/// sd is first order (delta method) with exact derivatives, through the full covariance, which is held as a
/// triangular factor R: the variance of a number with gradient g is |R^-T g|^2.
Crossings propagate(const ShotFit& fit, const PropagationOptions& options, Readout& readout);

}  // namespace strobe::reduction
