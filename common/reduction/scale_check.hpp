// The images' diameters among themselves, and against a calibrated scale. Part of the reduction, not of its
// interface. Thread-safe; no allocation.
#pragma once

#include "common/reduction/shot_fit.hpp"

namespace strobe::reduction {

/// Of the airborne images that were not left out. An offset common to all of them is no image's fault: it shows in
/// the mean, not in the scatter.
struct MeanDiameter {
  int count = 0;
  double mean_m = 0.0;           ///< weighted by the inverse variances
  double weight = 0.0;           ///< sum of these: the inverse of the mean's variance
  double sum_of_squares = 0.0;   ///< of the deviations from the mean, in variances
  bool estimated_noise = false;  ///< of some image
};
MeanDiameter mean_diameter(const ShotFit& fit);

/// Whether the diameters together contradict the calibrated scale: their mean against the ball's diameter on that
/// scale, with the standard deviations of the mean, the calibration and the ball's diameter. One clean photograph in a
/// thousand does. False without a calibration.
bool scale_contradicts_ball(const ShotFit& fit);

}  // namespace strobe::reduction
