// The global test: whether the residuals as a whole are explained by the noise that the frame states.
// Part of the reduction, not of its interface. Thread-safe; no allocation.
// Source: Koch, Parameter Estimation and Hypothesis Testing, 4.2.
#pragma once

#include "common/reduction/readout.hpp"
#include "common/reduction/shot_fit.hpp"

namespace strobe::reduction {

/// Sum of squared residuals in variances, over what they leave free.
struct ResidualScatter {
  double sum_of_squares = 0.0;
  double degrees_of_freedom = 0.0;
};

/// Of the measurements of one kind that are used and whose noise is stated, errors in time included. A leg takes
/// four degrees of freedom of its centres and two of its equators, the surface line two of its points, and the
/// diameters lose one: they are held against their own mean, so that a wrong scale is not taken for noise. What the
/// centres say of scale and tilt, through gravity, is left out: at most two degrees of freedom too many.
/// The spin's decay is fitted with its own uncertainty, and its deviation counts as a measurement's.
ResidualScatter scatter_of(const ShotFit& fit, MeasurementKind kind);

/// Whether chance explains so much scatter of one kind. The four kinds and all of them together share the false
/// alarms of a photograph evenly (Bonferroni).
bool exceeds_noise(const ResidualScatter& scatter);

/// Whether all kinds together, or one of them, exceed their noise, and by how much.
struct ResidualTest {
  bool exceeded = false;
  ResidualRatios ratios;
};
ResidualTest test_residuals(const ShotFit& fit);

}  // namespace strobe::reduction
