#include "host/digitize/equator/ball_pixels.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace strobe::digitize {
namespace {

/// Where a + b·i lies within -limit to limit.
std::pair<double, double> interval(double a, double b, double limit) {
  constexpr double kFar = 1e9;
  if (std::abs(b) < 1e-12) return std::abs(a) <= limit ? std::pair(-kFar, kFar) : std::pair(kFar, -kFar);
  const double one = (-limit - a) / b, two = (limit - a) / b;
  return {std::min(one, two), std::max(one, two)};
}

/// Where a row cuts the disc of `radii`: |first + i·step| <= radii.
std::pair<double, double> chord(cv::Point2d first, cv::Point2d step, double radii) {
  const double square = step.dot(step), middle = -first.dot(step) / square;
  const cv::Point2d nearest = first + middle * step;
  const double rest = radii * radii - nearest.dot(nearest);
  if (rest < 0.0) return {1.0, -1.0};
  const double half = std::sqrt(rest / square);
  return {middle - half, middle + half};
}

/// Of a disc, the unit coordinates of a row's first bin and the step from one bin to the next.
struct RowPlace {
  cv::Point2d first, step;

  RowPlace(const BinnedImage& image, const Disc& disc, int j)
      : first(disc.unit(image.column(0), image.row(j))),
        step(disc.unit_from_image(0, 0) * image.stride, disc.unit_from_image(1, 0) * image.stride) {}
};

}  // namespace

BallPixels::BallPixels(const BinnedImage& image, std::span<const Disc> discs,
                       std::span<const Shading> shadings, std::size_t ball,
                       std::span<const Neighbour> neighbours)
    : image_(&image),
      disc_(&discs[ball]),
      shading_(&shadings[ball]),
      floor_(0.05F * std::max(1e-6F, shadings[ball].at(0.0F, 0.0F, 1.0F))) {
  for (const Neighbour& neighbour : neighbours) {
    Other& other = others_.emplace_back(Other{&discs[neighbour.ball], &shadings[neighbour.ball], {}, {}});
    if (!neighbour.line) continue;
    other.place.emplace(*neighbour.line);
    other.shape.emplace(neighbour.line->shape);
    other.contrast = neighbour.line->contrast;
  }
}

cv::Range BallPixels::rows(double radii) const {
  const cv::Rect box = image_->around(*disc_, radii);
  return {box.y, box.y + box.height};
}

std::span<const BallPixels::Pixel> BallPixels::row(int j, double radii, const std::optional<Band>& band) {
  const RowPlace place(*image_, *disc_, j);
  auto [from, to] = chord(place.first, place.step, radii);
  if (band) {
    const double c = std::cos(band->angle_rad), s = std::sin(band->angle_rad);
    const auto [low, high] =
        interval(c * place.first.y - s * place.first.x, c * place.step.y - s * place.step.x, band->within);
    from = std::max(from, low);
    to = std::min(to, high);
  }
  from = std::max(0.0, std::ceil(from));
  to = std::min(image_->intensity.cols - 1.0, std::floor(to));
  row_.clear();
  if (to < from) return row_;
  const int start = static_cast<int>(from);
  const auto count = static_cast<std::size_t>(static_cast<int>(to) - start + 1);
  row_.resize(count);
  background_.assign(count, shading_->background);
  count_.assign(count, 1.0F);
  const float* intensity = image_->intensity.ptr<float>(j) + start;
  const auto inner = static_cast<float>((1.0 - disc_->rim) * (1.0 - disc_->rim));
  const cv::Point2f first(place.first + start * place.step), step(place.step);
  for (std::size_t i = 0; i < count; ++i) {
    Pixel& pixel = row_[i];
    pixel.u = first.x + static_cast<float>(i) * step.x;
    pixel.v = first.y + static_cast<float>(i) * step.y;
    const float r = pixel.u * pixel.u + pixel.v * pixel.v;
    pixel.z = std::sqrt(std::max(0.0F, 1.0F - r));
    pixel.shading = shading_->at(pixel.u, pixel.v, pixel.z);
    pixel.residual = intensity[i] - pixel.shading;
    pixel.variance = pixel.shading * pixel.shading;
    pixel.saturated = intensity[i] >= image_->saturation;
    pixel.usable = !pixel.saturated && r <= inner;
  }
  for (const Other& other : others_) subtract(other, j, start);
  for (std::size_t i = 0; i < count; ++i) row_[i].residual -= background_[i] / count_[i];
  return row_;
}

void BallPixels::subtract(const Other& other, int j, int start) {
  const RowPlace place(*image_, *other.disc, j);
  const double reach = 1.0 + other.disc->rim;
  const auto [from, to] = chord(place.first, place.step, reach);
  const int first = std::max(0, static_cast<int>(std::ceil(std::max(from, -1.0))) - start);
  const int last =
      std::min(static_cast<int>(row_.size()) - 1, static_cast<int>(std::floor(std::min(to, 1e6))) - start);
  const auto inner = static_cast<float>((1.0 - other.disc->rim) * (1.0 - other.disc->rim));
  for (int i = first; i <= last; ++i) {
    const auto at = static_cast<std::size_t>(i);
    Pixel& pixel = row_[at];
    const auto u = static_cast<float>(place.first.x + (start + i) * place.step.x);
    const auto v = static_cast<float>(place.first.y + (start + i) * place.step.y);
    const float r = u * u + v * v;
    if (r > inner) {
      pixel.usable = false;
      continue;
    }
    const float z = std::sqrt(std::max(0.0F, 1.0F - r));
    float light = other.shading->at(u, v, z);
    pixel.variance += light * light;
    background_[at] += other.shading->background;
    count_[at] += 1.0F;
    if (other.place) {
      const double f = other.place->across(u, v, z);
      if (std::abs(f) < other.shape->reach())
        light *= static_cast<float>(1.0 - other.contrast * other.shape->at(f).first);
    }
    pixel.residual -= light;
  }
}

namespace {

constexpr double kWithin = 0.22;  ///< half width of a profile, radii
constexpr double kMargin = 0.04;  ///< beyond it, for a line that moves while it is fitted

double bin_middle(int bin) { return kWithin * (2.0 * (bin + 0.5) / LineProfile::kBins - 1.0); }

struct ProfileFit {
  double contrast = 0.0;
  double residual = 0.0;  ///< sum of squares
};

/// Background of second order and the line's darkness.
ProfileFit fit_profile(const LineProfile::Sums& profile,
                       const std::array<double, LineProfile::kBins>& darkness) {
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
  const cv::Range range = pixels.rows(kInner);
  for (int j = range.start; j < range.end; ++j) {
    for (const BallPixels::Pixel& pixel : pixels.row(j, kInner, band)) {
      if (!pixel.usable || pixel.shading <= pixels.floor()) continue;
      if (std::abs(coordinates.across(pixel.u, pixel.v, pixel.z)) > within) continue;
      const cv::Point2f slope = pixels.shading().gradient(pixel.u, pixel.v, pixel.z) * (1.0F / pixel.shading);
      points.push_back({pixel.u, pixel.v, pixel.z, slope, pixel.residual / pixel.shading,
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
    const cv::Point2d steep = coordinates.gradient(point.u, point.v, point.z);
    const auto which = static_cast<std::size_t>(std::max(0.0, 2.0 * std::log2(cv::norm(steep)) + 0.5));
    if (which >= of_steepness.size()) continue;
    const auto at = static_cast<std::size_t>(bin);
    of_steepness[which].sum[at] += static_cast<double>(point.weight) * point.x;
    of_steepness[which].weight[at] += point.weight;
  }
}

void LineProfile::add(const LineProfile& other) {
  for (std::size_t which = 0; which < of_steepness.size(); ++which) {
    for (std::size_t bin = 0; bin < kBins; ++bin) {
      of_steepness[which].sum[bin] += other.of_steepness[which].sum[bin];
      of_steepness[which].weight[bin] += other.of_steepness[which].weight[bin];
    }
  }
}

ShapeGrid::ShapeGrid(double radius) {
  const double softest = std::max(0.004, 0.5 / radius);
  for (double half = 0.012; half < 0.13; half *= kHalfWidthStep) {
    for (double soft = softest; soft < 0.05; soft *= 1.7) {
      const LineShape shape{half, soft};
      if (shape.reach() > 0.8 * kWithin) continue;
      Trial& trial = trials_.emplace_back(Trial{shape, {}});
      for (std::size_t which = 0; which < trial.darkness.size(); ++which) {
        const LineShape seen{half, soft * LineProfile::kSteepness[which]};
        for (int bin = 0; bin < LineProfile::kBins; ++bin)
          trial.darkness[which][static_cast<std::size_t>(bin)] = seen.darkness(bin_middle(bin));
      }
    }
  }
}

LineShape ShapeGrid::best(const LineProfile& profile) const {
  LineShape best;
  double least = 1e300;
  for (const Trial& trial : trials_) {
    double dark = 0.0, residual = 0.0;
    for (std::size_t which = 0; which < trial.darkness.size(); ++which) {
      const auto& seen = profile.of_steepness[which];
      const double weight = std::reduce(seen.weight.begin(), seen.weight.end());
      if (weight <= 0.0) continue;
      const ProfileFit fit = fit_profile(seen, trial.darkness[which]);
      dark += weight * fit.contrast;
      residual += fit.residual;
    }
    if (!(dark > 0.0 && residual < least)) continue;
    least = residual;
    best = trial.shape;
  }
  return best;
}

}  // namespace strobe::digitize
