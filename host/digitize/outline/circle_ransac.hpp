// From a candidate to a circle good to about a pixel: the steepest rises of light towards the candidate's
// centre, ray by ray, and the circle that most of them agree on (random sample consensus, Fischler and Bolles
// 1981). Deterministic; thread-safe; allocates.
#pragma once

#include <optional>

#include "host/digitize/core/local_frame.hpp"
#include "host/digitize/image/photograph.hpp"

namespace strobe::digitize {

struct CoarseCircle {
  cv::Point2d centre;  ///< local px
  double radius = 0.0;
  double share = 0.0;  ///< of the rays that agree, weighted by how clear their edges are, 0 to 1
};

struct CoarseSearch {
  double radius_px = 0.0;  ///< local px, to start with
  double radius_min_px = 0.0, radius_max_px = 0.0;
  double reach_px = 0.0;  ///< how far from the start edges are looked for
};

/// Around the frame's origin. Absent: hardly an edge there.
std::optional<CoarseCircle> find_circle_ransac(const Photograph& photograph, const LocalFrame& frame,
                                               const CoarseSearch& search);

}  // namespace strobe::digitize
