// From a candidate to a circle within about a pixel: the steepest rises of intensity along rays, and the
// circle that most of them agree on (random sample consensus, Fischler and Bolles 1981). Deterministic;
// thread-safe; allocates.
#pragma once

#include <optional>

#include "host/digitize/image/photograph.hpp"
#include "host/digitize/outline/sector_samples.hpp"

namespace strobe::digitize {

struct CoarseCircle {
  cv::Point2d centre;  ///< local px
  double radius = 0.0;
  double support = 0.0;  ///< fraction of the rays that agree, weighted by how clear their edges are, 0 to 1
};

struct CoarseSearch {
  double radius_px = 0.0;  ///< first guess, local px
  double radius_min_px = 0.0, radius_max_px = 0.0;
  double reach_px = 0.0;  ///< how far from the first guess edges are searched
};

/// Around the frame's origin. Returns nullopt if hardly a ray has an edge.
std::optional<CoarseCircle> find_circle_ransac(const Photograph& photograph, const LocalFrame& frame,
                                               const CoarseSearch& search);

}  // namespace strobe::digitize
