// How light rises across the outline of a lit sphere that a lens has blurred: a step, and a part that grows
// with the root of the depth below the limb (the foreshortened surface turns to the camera as sqrt(1 - (1 -
// s/R)²)). Both convolved with a Gaussian of sd sigma. Depths s in px, positive inside. Pure; thread-safe;
// tables are built once.
#pragma once

namespace strobe::digitize {

/// A blurred function of depth and what it changes by when the outline moves out or the blur grows.
struct Blurred {
  double value = 0.0;
  double by_depth = 0.0;  ///< d/ds
  double by_sigma = 0.0;  ///< d/dsigma
};

/// Of the step at s = 0.
Blurred blurred_step(double depth_px, double sigma_px);

/// Of sqrt(s), s > 0.
Blurred blurred_root(double depth_px, double sigma_px);

/// Where the outline of a disc of that radius seems to lie after blur, px inside of where it is.
double inward_shift(double radius_px, double sigma_px);

}  // namespace strobe::digitize
