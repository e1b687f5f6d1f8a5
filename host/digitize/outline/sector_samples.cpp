#include "host/digitize/outline/sector_samples.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace strobe::digitize {

namespace {

constexpr int kTerms = 10;
using Monomials = std::array<double, kTerms>;

Monomials monomials(double u, double v) {
  return {1.0, u, v, u * u, u * v, v * v, u * u * u, u * u * v, u * v * v, v * v * v};
}

/// Fits cubics in (u, v) to points, by least squares.
class CubicFit {
 public:
  void add(double u, double v, cv::Point2d value) {
    const Monomials terms = monomials(u, v);
    for (int a = 0; a < kTerms; ++a) {
      const double term = terms[static_cast<std::size_t>(a)];
      for (int b = 0; b < kTerms; ++b) normal_(a, b) += term * terms[static_cast<std::size_t>(b)];
      right_(a, 0) += term * value.x;
      right_(a, 1) += term * value.y;
    }
  }
  void solve(Monomials& x, Monomials& y) const {
    const cv::Matx<double, kTerms, 2> solution = normal_.solve(right_, cv::DECOMP_CHOLESKY);
    for (int a = 0; a < kTerms; ++a) {
      x[static_cast<std::size_t>(a)] = solution(a, 0);
      y[static_cast<std::size_t>(a)] = solution(a, 1);
    }
  }

 private:
  cv::Matx<double, kTerms, kTerms> normal_ = cv::Matx<double, kTerms, kTerms>::zeros();
  cv::Matx<double, kTerms, 2> right_ = cv::Matx<double, kTerms, 2>::zeros();
};

}  // namespace

LocalFrame::LocalFrame(const PlaneMap& map, cv::Point2d centre_image, double reach_px)
    : uncalibrated_(map.is_uncalibrated()),
      centre_image_(centre_image),
      origin_(map.to_plane(centre_image)),
      scale_(map.image_px_per_plane_px(centre_image)),
      reach_px_(reach_px) {
  if (uncalibrated_) return;
  constexpr int kSide = 7;
  CubicFit fit;
  for (int i = 0; i < kSide; ++i) {
    for (int j = 0; j < kSide; ++j) {
      const double u = 2.0 * i / (kSide - 1) - 1.0, v = 2.0 * j / (kSide - 1) - 1.0;
      fit.add(u, v, map.to_image(to_plane(reach_px * cv::Point2d(u, v))));
    }
  }
  fit.solve(column_, row_);
}

double LocalFrame::at(const Cubic& cubic, double u, double v) {
  const Monomials terms = monomials(u, v);
  double sum = 0.0;
  for (std::size_t i = 0; i < terms.size(); ++i) sum += cubic[i] * terms[i];
  return sum;
}

namespace {

struct ImageSample {
  float intensity = 0.0F;
  bool inside = false;  ///< on the photograph
  bool saturated = false;
};

/// Bilinear interpolation.
class Sampler {
 public:
  explicit Sampler(const Photograph& photograph)
      : first_(photograph.intensity.ptr<float>()),
        row_(static_cast<std::ptrdiff_t>(photograph.intensity.step1())),
        right_(photograph.width() - 1),
        bottom_(photograph.height() - 1),
        full_(static_cast<float>(0.985 * photograph.saturation)) {}

  ImageSample at(cv::Point2d image) const {
    if (!(image.x >= 0.0 && image.y >= 0.0 && image.x < right_ && image.y < bottom_)) return {};
    const int x = static_cast<int>(image.x), y = static_cast<int>(image.y);
    const float* above = first_ + static_cast<std::ptrdiff_t>(y) * row_ + x;
    const float* below = above + row_;
    const auto u = static_cast<float>(image.x - x), v = static_cast<float>(image.y - y);
    const float top = above[0] + u * (above[1] - above[0]), bottom = below[0] + u * (below[1] - below[0]);
    const float most = std::max(std::max(above[0], above[1]), std::max(below[0], below[1]));
    return {top + v * (bottom - top), true, most >= full_};
  }

 private:
  const float* first_;
  std::ptrdiff_t row_;
  double right_, bottom_;
  float full_;
};

}  // namespace

SectorSamples::SectorSamples(const Photograph& photograph, const LocalFrame& frame, const OutlineShape& shape,
                             const SectorGrid& grid)
    : sectors_(static_cast<std::size_t>(grid.sectors)),
      outside_(grid.outside_px),
      window_(std::max(grid.outside_px, grid.inside_px)) {
  const double across = grid.outside_px + grid.inside_px;
  // On a small ball, enough depths to separate the model's terms.
  step_ = std::max(across / (kMaxDepths - 1), std::min(1.0, across / 20.0));
  depths_ = std::min(kMaxDepths, static_cast<int>(across / step_) + 1);
  intensity_.assign(sectors_.size() * static_cast<std::size_t>(depths_), 0.0F);
  std::vector<char> flawed;
  for (int i = 0; i < count(); ++i) sample(photograph, frame, shape, i, grid.rays, flawed);
}

void SectorSamples::sample(const Photograph& photograph, const LocalFrame& frame, const OutlineShape& shape,
                           int index, int rays, std::vector<char>& flawed) {
  Sector& own = sectors_[static_cast<std::size_t>(index)];
  const Sampler sampler(photograph);
  float* intensity = &intensity_[static_cast<std::size_t>(index * depths_)];
  flawed.assign(static_cast<std::size_t>(depths_), 0);
  const double middle = 2.0 * std::numbers::pi * (index + 0.5) / count();
  own.out = {std::cos(middle), std::sin(middle)};
  own.radius = shape.radius_towards(own.out.x, own.out.y);
  own.middle = shape.centre + own.out * own.radius;
  int inside = 0, saturated = 0;
  for (int ray = 0; ray < rays; ++ray) {
    const double turn = 2.0 * half_width_rad() * ((ray + 0.5) / rays - 0.5);
    const double c = std::cos(turn), s = std::sin(turn);
    const cv::Point2d out(own.out.x * c - own.out.y * s, own.out.x * s + own.out.y * c);
    const cv::Point2d outermost = shape.centre + out * (shape.radius_towards(out.x, out.y) + outside_);
    const cv::Point2d from = frame.to_image(outermost);
    const cv::Point2d along = frame.is_uncalibrated() ? cv::Point2d(-out.x, out.y) * step_ : cv::Point2d();
    for (int k = 0; k < depths_; ++k) {
      const ImageSample one =
          sampler.at(frame.is_uncalibrated() ? from + static_cast<double>(k) * along
                                             : frame.to_image(outermost - out * (k * step_)));
      intensity[k] += one.intensity;
      inside += one.inside ? 1 : 0;
      if (one.inside && !one.saturated) continue;
      flawed[static_cast<std::size_t>(k)] = 1;
      if (!one.saturated) continue;
      ++saturated;
      const double depth = depth_px(k);
      double& nearest = depth > 0.0 ? own.saturated_inside : own.saturated_outside;
      nearest = depth > 0.0 ? std::min(nearest, depth) : std::max(nearest, depth);
    }
  }
  for (int k = 0; k < depths_; ++k) intensity[k] /= static_cast<float>(rays);
  own.inside = static_cast<double>(inside) / (rays * depths_);
  own.saturated = inside > 0 ? static_cast<double>(saturated) / inside : 0.0;
  choose_depths(own, flawed);
}

/// The depths around the outline without a flawed sample: where some are saturated, the mean of the others is
/// biased.
void SectorSamples::choose_depths(Sector& own, const std::vector<char>& flawed) const {
  const auto usable = [&](int k) {
    return flawed[static_cast<std::size_t>(k)] == 0 && depth_px(k) <= own.saturated_inside - 1.0 &&
           depth_px(k) >= own.saturated_outside + 1.0;
  };
  const int outline = std::clamp(static_cast<int>(outside_ / step_ + 0.5), 0, depths_ - 1);
  if (!usable(outline)) return;
  int last = outline;
  own.first = outline;
  while (own.first > 0 && usable(own.first - 1)) --own.first;
  while (last + 1 < depths_ && usable(last + 1)) ++last;
  own.size = last - own.first + 1;
}

double SectorSamples::half_width_rad() const { return std::numbers::pi / count(); }

SectorSamples::Profile SectorSamples::profile(int index) const {
  const Sector& own = sector(index);
  const auto begin = static_cast<std::size_t>(index * depths_ + own.first);
  return {depth_px(own.first), std::span(intensity_).subspan(begin, static_cast<std::size_t>(own.size))};
}

}  // namespace strobe::digitize
