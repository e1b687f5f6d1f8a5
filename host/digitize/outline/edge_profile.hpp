// Model of the intensity across the outline of a lit sphere, blurred by a lens: a step, and a part that grows
// with the square root of the depth s below the limb (the surface turns to the camera as sqrt(1 - (1 -
// s/R)²)), both convolved with a Gaussian of sd sigma. Depths in px, positive inside. Pure; thread-safe;
// tables are built once.
#pragma once

#include <array>
#include <vector>

namespace strobe::digitize {

/// A blurred function of depth and its derivatives.
struct BlurredValue {
  double value = 0.0;
  double by_depth = 0.0;  ///< d/ds
  double by_sigma = 0.0;  ///< d/dsigma
};

/// Unit step at s = 0.
BlurredValue blurred_step(double depth_px, double sigma_px);

/// sqrt(s) for s > 0, else 0.
BlurredValue blurred_sqrt(double depth_px, double sigma_px);

/// By how much blur moves the apparent outline of a disc inwards [px].
double inward_shift(double radius_px, double sigma_px);

/// Both profiles at one blur, tabulated in steps of a sixteenth of a px.
class ProfileTable {
 public:
  /// The square root is that of a sphere of that radius, over the root of `unit_px`. Depths beyond shallowest
  /// and deepest are clamped.
  ProfileTable(double sigma_px, double radius_px, double unit_px, double shallowest_px, double deepest_px);

  struct Entry {
    /// Values, their d/ddepth and d/dsigma.
    float step, root, step_by_depth, root_by_depth, step_by_sigma, root_by_sigma;
  };
  Entry at(double depth_px) const;

  struct Mean {
    float step, root;
  };
  /// Over depths uniform between the two.
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
