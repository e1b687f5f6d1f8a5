#include "common/geometry/line.hpp"

#include <cassert>
#include <cmath>

namespace strobe::geometry {

std::optional<Line> fit_line(std::span<const Eigen::Vector2d> points, std::span<const double> weights,
                             double min_spread) {
  assert(weights.empty() || weights.size() == points.size());
  if (points.empty()) return std::nullopt;
  const auto weight = [&](std::size_t i) { return weights.empty() ? 1.0 : weights[i]; };
  Line line;
  line.reference = points.front();
  double sum = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) sum += weight(i);
  for (std::size_t i = 0; i < points.size(); ++i)
    line.centroid += weight(i) * (points[i] - line.reference) / sum;
  double sxx = 0.0, sxy = 0.0, syy = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector2d d = (points[i] - line.reference) - line.centroid;
    sxx += weight(i) * d.x() * d.x();
    sxy += weight(i) * d.x() * d.y();
    syy += weight(i) * d.y() * d.y();
  }
  if (!(sxx + syy > min_spread * min_spread)) return std::nullopt;
  line.tilt = Rotation2d(0.5 * std::atan2(2.0 * sxy, sxx - syy));
  return line;
}

}  // namespace strobe::geometry
