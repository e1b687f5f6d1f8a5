#include <algorithm>
#include <cmath>

#include "common/flight/gravity.hpp"
#include "host/digitize/core/eigen.hpp"
#include "host/digitize/core/statistics.hpp"
#include "host/digitize/path/path.hpp"

namespace strobe::digitize {
namespace {

// Contact shows from a hundredth of the radius on.
constexpr double kMinCompressionOfRadius = 0.01;
// A wide lens without a calibration moves centres by about that share of the diameter against a smooth path.
constexpr double kLensOfDiameter = 0.005;

}  // namespace

double variance_across(const PathPoint& point, double diameter_px) {
  const double lens = kLensOfDiameter * diameter_px;
  return point.sd_px * point.sd_px + lens * lens;
}

std::vector<PathPoint> path_points(std::span<const Outline> outlines,
                                   const std::optional<SurfaceLine>& surface) {
  const geometry::SurfaceFrame axes = surface ? surface_frame(*surface) : geometry::SurfaceFrame{};
  std::vector<PathPoint> points;
  points.reserve(outlines.size());
  for (const Outline& o : outlines)
    points.push_back({to_point(axes.from_image(to_eigen(o.centre))), o.centre_sd(),
                      0.3 + 0.7 * std::clamp(o.visible_fraction, 0.0, 1.0)});
  return points;
}

PathContext path_context(std::span<const Outline> outlines, const std::optional<SurfaceLine>& surface,
                         double ball_diameter_m, std::span<const double> flash_times_s) {
  std::vector<double> diameters;
  for (const Outline& o : outlines) diameters.push_back(o.diameter);
  PathContext context{median(std::move(diameters)), surface.has_value(),
                      surface ? height_sd_px(*surface) : 0.0};
  context.flash_times_s = flash_times_s;
  context.gravity_pxps2 = flight::kStandardGravity_mps2 * context.diameter_px / ball_diameter_m;
  return context;
}

bool is_partition(const Path& path, std::size_t points) {
  std::vector<int> count(points, 0);
  const auto add = [&](int i) { ++count.at(static_cast<std::size_t>(i)); };
  for (const auto& leg : path.legs) std::ranges::for_each(leg, add);
  std::ranges::for_each(path.contact, add);
  for (const Path::Outlier& outlier : path.outliers) add(outlier.index);
  return std::ranges::all_of(count, [](int n) { return n == 1; });
}

bool touches(double height_px, double sd_px, const PathContext& context) {
  if (!context.surface_known) return false;
  const double radius = 0.5 * context.diameter_px;
  return height_px <
         radius - std::max(4.0 * std::hypot(sd_px, context.surface_sd_px), kMinCompressionOfRadius * radius);
}

}  // namespace strobe::digitize
