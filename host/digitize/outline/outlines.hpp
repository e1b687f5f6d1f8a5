// From candidates to outlines: sub-pixel edges along the normals, and the outline that a ball has in the
// plane fitted to those that are its own. Deterministic for any number of threads; thread-safe; allocates.
#pragma once

#include <span>
#include <vector>

#include "host/digitize/core/plane_map.hpp"
#include "host/digitize/core/types.hpp"
#include "host/digitize/image/photograph.hpp"

namespace strobe::digitize {

struct OutlineSettings {
  double diameter_min_px = 0.0;  ///< plane px
  double diameter_max_px = 0.0;
  /// The ball's diameter and its sd, where known well enough to help short arcs.
  std::optional<double> diameter_px;
  std::optional<double> diameter_sd_px;
  Effort effort = Effort::standard;
};

/// One result for each candidate, in their order. All candidates are fitted together: edges of another
/// outline are left to it. Contact images are fitted to what is round of them. The covariances are
/// calibrated: error/sd has rms one over many photographs, whatever texture, shading and noise.
std::vector<Measured<Outline>> fit_outlines(const Photograph& photograph, const PlaneMap& map,
                                            std::span<const Candidate> candidates,
                                            const OutlineSettings& settings);

}  // namespace strobe::digitize
