// A photograph altered in ways that move no ball, or all alike: what is found must stay the same.
// Deterministic; thread-safe; allocates.
#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <string_view>
#include <vector>

#include "tests/real/collection.hpp"

namespace strobe::real {

/// Where things go: (x, y) to (a[0]x + a[1]y + a[2], a[3]x + a[4]y + a[5]), in px.
using Move = std::array<double, 6>;
inline constexpr Move kStay{1.0, 0.0, 0.0, 0.0, 1.0, 0.0};

Point moved(Point point, const Move& move);

struct Altered {
  cv::Mat pixels;
  Move move = kStay;
  double scale = 1.0;  ///< of lengths
};

struct Alteration {
  std::string_view name;
  std::string_view words;  ///< what is done
  Altered (*make)(const cv::Mat& pixels);
  bool keeps_gravity = true;  ///< if not: none of a curved path or a bounce, as balls do not fall upwards
};

/// The first is none at all: the photograph as it is. Pixels: CV_8U or CV_16U of 1 or 3 channels, which stay
/// so.
const std::vector<Alteration>& alterations();

/// Its truth: balls, ghosts and scale moved along. Of a ball that was wholly in the picture and now is not,
/// `optional` is the kind.
Photograph altered_truth(const Photograph& photograph, const Altered& altered, cv::Size before);

}  // namespace strobe::real
