// The pixels around an outline. Header only; thread-safe; no allocation.
#pragma once

#include <algorithm>
#include <cmath>

#include "host/digitize/local_frame.hpp"
#include "host/digitize/photograph.hpp"

namespace strobe::digitize {

/// Calls visit(cv::Point2d local_px, float light) for each pixel of the photograph whose distance from
/// `centre` (local px) is between the radii, and for some just beyond where the lens bends the map; row by
/// row.
template <typename Visit>
void visit_annulus(const Photograph& photograph, const LocalFrame& frame, cv::Point2d centre, double inner,
                   double outer, const Visit& visit) {
  // Pixels have the frame's unit size, so that distances carry over but for what the map bends or shears.
  const bool bent = !frame.is_plain();
  const double slack = bent ? 0.03 * outer + 1.0 : 0.0;
  const cv::Point2d middle = frame.to_image(centre);
  const double far = outer + slack, near = std::max(0.0, inner - slack);
  const int top = std::max(0, static_cast<int>(std::ceil(middle.y - far)));
  const int bottom = std::min(photograph.height() - 1, static_cast<int>(std::floor(middle.y + far)));
  const auto run = [&](int row, double from, double to) {
    const int first = std::max(0, static_cast<int>(std::ceil(middle.x + from)));
    const int last = std::min(photograph.width() - 1, static_cast<int>(std::floor(middle.x + to)));
    const float* light = photograph.light.ptr<float>(row);
    for (int column = first; column <= last; ++column) visit(frame.from_image(column, row), light[column]);
  };
  for (int row = top; row <= bottom; ++row) {
    const double y = row - middle.y;
    const double wide = std::sqrt(std::max(0.0, far * far - y * y));
    const double hole2 = near * near - y * y;
    if (hole2 <= 1.0) {
      run(row, -wide, wide);
    } else {
      const double hole = std::sqrt(hole2);
      run(row, -wide, -hole);
      run(row, std::nextafter(hole, far), wide);
    }
  }
}

}  // namespace strobe::digitize
