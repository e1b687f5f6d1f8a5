#include "host/digitize/equator/line_shape.hpp"

#include <algorithm>
#include <cmath>

namespace strobe::digitize {
namespace {

constexpr double kShapeInner = 0.95;  ///< radii of the disc that are used
constexpr double kWithin = 0.22;      ///< half width of a profile, radii
constexpr double kMargin = 0.04;      ///< beyond it, for a line that moves while it is fitted

double bin_middle(int bin) { return kWithin * (2.0 * (bin + 0.5) / LineProfile::kBins - 1.0); }

struct ProfileFit {
  double contrast = 0.0;
  double residual = 0.0;  ///< sum of squares
};

/// Background of second order and the line's darkness.
ProfileFit fit_profile(const LineProfile& profile, const std::array<double, LineProfile::kBins>& darkness) {
  cv::Matx33d normal = cv::Matx33d::eye() * 1e-9;
  cv::Vec3d right;
  double square = 0.0;
  for (std::size_t bin = 0; bin < LineProfile::kBins; ++bin) {
    const double w = profile.weight[bin];
    if (w <= 0.0) continue;
    const double f = bin_middle(static_cast<int>(bin)), sum = profile.sum[bin];
    const cv::Vec3d row(1.0, f * f, darkness[bin]);
    for (int a = 0; a < 3; ++a) {
      right[a] += row[a] * sum;
      for (int b = 0; b < 3; ++b) normal(a, b) += w * row[a] * row[b];
    }
    square += sum * sum / w;
  }
  const cv::Vec3d fit = normal.solve(right, cv::DECOMP_CHOLESKY);
  return {-fit[2], square - fit.dot(right)};
}

}  // namespace

std::vector<LinePoint> points_near(BallPixels& pixels, const EquatorLine& line) {
  std::vector<LinePoint> points;
  const LineCoordinates coordinates(line);
  const double within = kWithin + kMargin;
  const BallPixels::Band band{line.angle_rad,
                              within + std::abs(std::sin(line.tilt_rad)) + std::abs(line.offset)};
  const float floor2 = pixels.floor() * pixels.floor();
  const cv::Range range = pixels.rows(kShapeInner);
  for (int j = range.start; j < range.end; ++j) {
    for (const BallPixels::Pixel& pixel : pixels.row(j, kShapeInner, band)) {
      if (!pixel.usable || pixel.shading <= pixels.floor()) continue;
      if (std::abs(coordinates.across(pixel.u, pixel.v, pixel.z)) > within) continue;
      points.push_back({pixel.u, pixel.v, pixel.z, pixel.residual / pixel.shading,
                        pixel.shading * pixel.shading / (pixel.variance + floor2)});
    }
  }
  return points;
}

void LineProfile::add(std::span<const LinePoint> points, const EquatorLine& line) {
  const LineCoordinates coordinates(line);
  for (const LinePoint& point : points) {
    const double f = coordinates.across(point.u, point.v, point.z);
    const double bin = (f / kWithin + 1.0) * 0.5 * kBins;
    if (!(bin >= 0.0 && bin < kBins)) continue;
    const auto at = static_cast<std::size_t>(bin);
    sum[at] += static_cast<double>(point.weight) * point.x;
    weight[at] += point.weight;
  }
}

void LineProfile::add(const LineProfile& other) {
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    sum[bin] += other.sum[bin];
    weight[bin] += other.weight[bin];
  }
}

ShapeGrid::ShapeGrid(double radius) {
  const double softest = std::max(0.004, 0.5 / radius);
  for (double half = 0.012; half < 0.13; half *= kHalfWidthStep) {
    for (double soft = softest; soft < 0.05; soft *= 1.7) {
      const LineShape shape{half, soft};
      if (shape.reach() > 0.8 * kWithin) continue;
      Trial& trial = trials_.emplace_back(Trial{shape, {}});
      for (int bin = 0; bin < LineProfile::kBins; ++bin)
        trial.darkness[static_cast<std::size_t>(bin)] = shape.darkness(bin_middle(bin));
    }
  }
}

LineShape ShapeGrid::best(const LineProfile& profile) const {
  LineShape best;
  double least = 1e300;
  for (const Trial& trial : trials_) {
    const ProfileFit fit = fit_profile(profile, trial.darkness);
    if (!(fit.contrast > 0.0 && fit.residual < least)) continue;
    least = fit.residual;
    best = trial.shape;
  }
  return best;
}

}  // namespace strobe::digitize
