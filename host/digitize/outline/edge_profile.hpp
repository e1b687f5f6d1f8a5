// How light rises across the outline of a lit sphere that a lens has blurred: a step, and a part that grows
// with the root of the depth below the limb (the foreshortened surface turns to the camera as sqrt(1 - (1 -
// s/R)²)). Both convolved with a Gaussian of sd sigma. Depths s in px, positive inside. Pure; thread-safe;
// tables are built once.
#pragma once

#include <array>
#include <vector>

namespace strobe::digitize {

/// A blurred function of depth and what it changes by when the outline moves out or the blur grows.
struct BlurredValue {
  double value = 0.0;
  double by_depth = 0.0;  ///< d/ds
  double by_sigma = 0.0;  ///< d/dsigma
};

/// Of the step at s = 0.
BlurredValue blurred_step(double depth_px, double sigma_px);

/// Of sqrt(s), s > 0.
BlurredValue blurred_sqrt(double depth_px, double sigma_px);

/// Where the outline of a disc of that radius seems to lie after blur, px inside of where it is.
double inward_shift(double radius_px, double sigma_px);

/// Both profiles at one blur, for very many depths on one ball: a table with steps of a sixteenth of a px.
class ProfileTable {
 public:
  /// The root is that of a sphere of that radius, over the root of `unit_px`. Depths to look up are taken to
  /// lie between shallowest and deepest; what is beyond is cut off there.
  ProfileTable(double sigma_px, double radius_px, double unit_px, double shallowest_px, double deepest_px);

  struct Entry {
    /// Values, their d/ddepth and d/dsigma.
    float step, root, step_by_depth, sqrt_by_depth, step_by_sigma, sqrt_by_sigma;
  };
  Entry at(double depth_px) const;

  struct Mean {
    float step, root;
  };
  /// Over depths that spread evenly between the two.
  Mean mean(double from_px, double to_px) const;

 private:
  struct Sums {
    double step, root;
  };
  double position(double depth_px) const;
  Sums sum_at(double position) const;

  double shallowest_;
  std::vector<Entry> entries_;
  std::vector<Sums> sums_;  ///< integrals up to each entry
};

}  // namespace strobe::digitize
