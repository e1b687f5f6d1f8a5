// Whether residuals scatter more than the noise that the frame states explains, all together (the global
// test) and of each kind, and whether the diameters contradict a calibrated scale. Part of the reduction, not
// of its interface. Pure functions; thread-safe; no allocation.
#pragma once

#include "common/reduction/readout.hpp"
#include "common/reduction/shot_fit.hpp"

namespace strobe::reduction {

/// Share of clean photographs that each check of consistency may take for bad.
inline constexpr double kFalseAlarms = 1e-3;

/// Probability that normal errors give a sum of squares, over their variance, of at least this much.
/// `noise_freedom` are the degrees of freedom which that variance was estimated with: infinity where it is
/// known (chi squared), else F. 1 for no degrees of freedom.
/// Source: Koch, Parameter Estimation and Hypothesis Testing, 4.2 (the global test of an adjustment).
double chance_of_scatter(double sum_of_squares, double degrees_of_freedom, double noise_freedom);

/// Sum of squared residuals in variances, over what they leave free.
struct ResidualScatter {
  double sum_of_squares = 0.0;
  double degrees_of_freedom = 0.0;
};

/// Of the measurements of one kind that are used and whose noise is stated, errors in time included. A leg
/// takes four degrees of freedom of its centres and two of its equators, the surface line two of its points,
/// and the diameters lose one: they are held against their own mean, so that a wrong scale is not taken for
/// noise. What the centres say of scale and tilt, through gravity, is left out: at most two degrees of
/// freedom too many. The spin's decay is fitted with its own uncertainty, and its deviation counts as a
/// measurement's.
ResidualScatter scatter_of(const ShotFit& fit, MeasurementKind kind);

/// Of the surface points' distances from the fitted line. [m^2]
double surface_square_sum(const ShotFit& fit);

/// Whether chance explains so much scatter of one kind. The four kinds and all of them together share the
/// false alarms of a photograph evenly (Bonferroni).
bool exceeds_noise(const ResidualScatter& scatter);

/// Whether all kinds together, or one of them, exceed their noise, and by how much.
struct ResidualTest {
  bool exceeded = false;
  ResidualRatios ratios;
};
ResidualTest test_residuals(const ShotFit& fit);

/// The images' diameters among themselves: of the airborne ones that were not left out. An offset common to
/// all of them is no image's fault: it shows in the mean, not in the scatter.
struct MeanDiameter {
  int count = 0;
  double mean_m = 0.0;           ///< weighted by the inverse variances
  double weight = 0.0;           ///< sum of these: the inverse of the mean's variance
  double sum_of_squares = 0.0;   ///< of the deviations from the mean, in variances
  bool estimated_noise = false;  ///< of some image
};
MeanDiameter mean_diameter(const ShotFit& fit);

/// Whether the diameters together contradict the calibrated scale: their mean against the ball's diameter on
/// that scale, with the standard deviations of the mean, the calibration and the ball's diameter. One clean
/// photograph in a thousand does. False without a calibration.
bool scale_contradicts_ball(const ShotFit& fit);

}  // namespace strobe::reduction
