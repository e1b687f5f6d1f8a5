// From candidates to outlines: sub-pixel edges along the normals, and the outline that a ball has in the
// plane fitted to those that are its own. Deterministic for any number of threads; thread-safe; allocates.
#pragma once

#include <span>
#include <vector>

#include "host/digitize/core/plane_map.hpp"
#include "host/digitize/core/types.hpp"
#include "host/digitize/image/photograph.hpp"
#include "host/digitize/outline/outline_fit.hpp"

namespace strobe::digitize {

// An outline fitted several times, with sectors of other lengths and depths, and the mean of the middle half
// of the results. Which sectors are outliers depends on the sectors, so that single results differ by about
// as much as their errors: the mean is closer to the truth, above all where little is visible (bagging,
// Breiman 1996). Deterministic; thread-safe; allocates.

/// As fit_outline(), at some five times the cost. The covariance includes how far the fits differ. Returns
/// nullopt if none of them has enough sectors with an edge.
std::optional<FittedOutline> fit_outline_bagged(const Photograph& photograph, const LocalFrame& frame,
                                                const OutlineShape& start, double sigma_px,
                                                std::span<const OutlineShape> neighbours,
                                                const OutlineFitSettings& settings);

struct OutlineSettings {
  double diameter_min_px = 0.0;  ///< plane px
  double diameter_max_px = 0.0;
  /// The ball's diameter at x = 0, how it grows along x, and its sd, where known well enough to help short
  /// arcs.
  std::optional<double> diameter_px;
  double diameter_slope = 0.0;
  std::optional<double> diameter_sd_px;
  Effort effort = Effort::standard;
  /// Measured before, plane px: edges are left to them, too. Must outlive the fit.
  std::span<const Outline> neighbours{};
  /// As an earlier fit on this photograph found them; absent: from these candidates' own outlines.
  std::optional<OvalModel> ovals;
};

struct FittedOutlines {
  std::vector<Measured<Outline>> outlines;  ///< one for each candidate, in their order
  std::optional<OvalModel> ovals;           ///< absent: too few are seen over half of their circle
};

/// All candidates are fitted together: edges of another outline are left to it. Contact images are fitted to
/// what is round of them. Where no calibration tells where the lens is, outlines are as oval as those that
/// are seen over half of their circle show others to be there. The covariances are calibrated: error/sd has
/// rms one over many photographs, whatever texture, shading and noise.
FittedOutlines fit_outlines(const Photograph& photograph, const PlaneMap& map,
                            std::span<const Candidate> candidates, const OutlineSettings& settings);

}  // namespace strobe::digitize
