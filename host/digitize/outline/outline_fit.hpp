// One outline fitted to its sectors (edge_sectors.hpp): robust weighted least squares for centre, radius, a
// slight oval and the blur, and a covariance from the scatter of the sectors themselves, which are correlated
// as felt and shading are (sandwich estimator with Bartlett's window along the outline, Newey and West 1987).
// Deterministic; thread-safe; allocates.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "host/digitize/core/types.hpp"
#include "host/digitize/outline/edge_sectors.hpp"

namespace strobe::digitize {

struct OutlineFitSettings {
  int steps = 4;
  int rough_steps = 2;      ///< of those, the first, from a start that may be off by more than a px
  double sectors_px = 8.0;  ///< length of one
  double rays_px = 1.0;     ///< between the rays on which light is sampled
  /// How far out and in the light is looked at, beyond three sd of the blur.
  double outside_px = 4.0, inside_px = 6.0;
  cv::Vec2d oval;                                 ///< expected, cos and sin over the radius
  double oval_sd = 0.005;                         ///< of it
  std::optional<double> radius_px, radius_sd_px;  ///< known beforehand
};

struct FittedOutline {
  OutlineShape shape;
  double sigma_px = 1.0;
  cv::Matx<double, 5, 5> covariance;  ///< centre x, y, radius, oval cos, sin [local px²]
  std::vector<double> weight;         ///< by sector: 0, not used, to 1
  std::vector<Arc> seen;
  double visible_fraction = 0.0;
  double saturated_fraction = 0.0;  ///< of the outline
  double outside_fraction = 0.0;    ///< of the outline, beyond the photograph's border
  double rms_px = 0.0;
  double scatter_px = 0.0;  ///< of the sectors beyond what their pixels' noise explains
};

/// Absent: too few sectors with an edge.
std::optional<FittedOutline> fit_outline(const Photograph& photograph, const LocalFrame& frame,
                                         const OutlineShape& start, double sigma_px,
                                         std::span<const OutlineShape> neighbours,
                                         const OutlineFitSettings& settings);

/// The fit as it would be had the oval been known beforehand, over the radius, with an sd less than the
/// `former_sd` around none that it was fitted with. An oval that is clearly another is left as it is.
void apply_oval_prior(FittedOutline& fitted, cv::Vec2d oval, double sd, double former_sd);

}  // namespace strobe::digitize
