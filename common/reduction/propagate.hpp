// From fitted unknowns to the readout's numbers and their standard deviations.
// Part of the reduction, not of its interface. Thread-safe.
#pragma once

#include <optional>

#include "common/reduction/readout.hpp"
#include "common/reduction/shot_fit.hpp"

namespace strobe::reduction {

/// I / (m R^2) of a tennis ball, as measured (Cross). It only decides what rolling would need, hence the
/// regime.
inline constexpr double kInertiaFactor = 0.55;

/// Fills value, sd, sd_systematic, regime and court pace, and sets too_few_images and degenerate_geometry.
/// Touchdown and lift-off are where the fitted flight has its centre one radius above the fitted line. Every
/// sd is first order (delta method) with exact derivatives, through the full covariance.
void propagate(const ShotFit& fit, std::optional<double> temperature_c, Readout& readout);

}  // namespace strobe::reduction
