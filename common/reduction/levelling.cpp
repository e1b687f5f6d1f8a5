#include "common/reduction/levelling.hpp"

#include <cmath>

namespace strobe::reduction {

std::optional<Levelling> level(const std::vector<PointPx>& surface_px, double px_per_m) {
  Levelling result;
  result.px_per_m = px_per_m;
  if (surface_px.empty()) return std::nullopt;
  // Differences of neighbouring coordinates are exact, however far from zero the coordinates are.
  result.origin_px = surface_px.front();
  const auto from_origin = [&](const PointPx& p) {
    return PointPx{p.x - result.origin_px.x, p.y - result.origin_px.y};
  };
  const double n = static_cast<double>(surface_px.size());
  for (const PointPx& p : surface_px) {
    const PointPx d = from_origin(p);
    result.centroid_px.x += d.x / n;
    result.centroid_px.y += d.y / n;
  }
  double sxx = 0.0;
  double sxy = 0.0;
  double syy = 0.0;
  for (const PointPx& p : surface_px) {
    const PointPx d = from_origin(p);
    const double dx = d.x - result.centroid_px.x;
    const double dy = d.y - result.centroid_px.y;
    sxx += dx * dx;
    sxy += dx * dy;
    syy += dy * dy;
  }
  // A hundredth of a millimetre is beneath any digitizer: such points are one point.
  const double least_px = 1e-5 * px_per_m;
  if (!(sxx + syy > least_px * least_px)) return std::nullopt;
  const double tilt = 0.5 * std::atan2(2.0 * sxy, sxx - syy);
  result.cos_tilt = std::cos(tilt);
  result.sin_tilt = std::sin(tilt);
  return result;
}

}  // namespace strobe::reduction
