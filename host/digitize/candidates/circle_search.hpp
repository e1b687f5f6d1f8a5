// Circles through the edge points of a picture: edge points vote for the centres that their gradients point to
// (Hough transform for circles), and the circles that most of them support are taken first. Deterministic for any
// number of threads; thread-safe; allocates.
#pragma once

#include <cstddef>
#include <vector>

#include "host/digitize/candidates/circle_support.hpp"

namespace strobe::digitize {

/// In px of the picture that the edge points are from.
struct CircleSearch {
  double radius_min = 0.0;
  double radius_max = 0.0;
  double min_coverage = 0.2;    ///< smallest visible fraction of an outline
  std::size_t max_peaks = 250;  ///< of the votes, highest first, at which a circle is fitted
};

/// Best first when found, at least a tenth of the radius apart; none shares its edge points with a better one.
/// `support` is made of `edges`, whose picture has that size; afterwards the circles' edge points are claimed.
std::vector<SupportedCircle> find_circles(const std::vector<EdgePoint>& edges, CircleSupport& support,
                                          cv::Size size, const CircleSearch& search);

}  // namespace strobe::digitize
