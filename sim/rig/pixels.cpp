#include "sim/rig/pixels.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace strobe::sim {

namespace {

constexpr double kBarLength = 0.6;  // half length and half width of the bar over the half diameter
constexpr double kBarWidth = 0.06;
constexpr double kBarReach = 0.61;  // of its corners: hypot(.6, .06) = .603
constexpr double kInside = 0.8;     // of the half diameter: what is not brightest in there is the bar

struct Span {
  double from = 0.0;
  double to = 0.0;
};

/// Where a line at height h above the centre of an ellipse meets it.
class EllipseCut {
 public:
  explicit EllipseCut(const BallView& view) {
    const double c = std::cos(view.axis_rad);
    const double s = std::sin(view.axis_rad);
    const double aa = 1.0 / (view.along_px * view.along_px);
    const double bb = 1.0 / (view.across_px * view.across_px);
    xx_ = c * c * aa + s * s * bb;
    xy_ = c * s * (aa - bb);
    det_ = aa * bb;
  }
  Span at(double h) const {
    const double root = xx_ - h * h * det_;
    if (root <= 0.0) return {};
    const double half = std::sqrt(root) / xx_;
    const double middle = -xy_ * h / xx_;
    return {middle - half, middle + half};
  }

 private:
  double xx_, xy_, det_;
};

/// Where |x·nx + h·ny| <= half.
Span strip(double nx, double ny, double half, double h) {
  constexpr double kFar = 1e9;
  if (std::abs(nx) < 1e-12) return std::abs(h * ny) <= half ? Span{-kFar, kFar} : Span{};
  const double a = (-half - h * ny) / nx;
  const double b = (half - h * ny) / nx;
  return {std::min(a, b), std::max(a, b)};
}

class BarCut {
 public:
  BarCut(double angle_rad, double half_diameter_px)
      : c_(std::cos(angle_rad)), s_(std::sin(angle_rad)), r_(half_diameter_px) {}
  Span at(double h) const {
    const Span along = strip(c_, s_, kBarLength * r_, h);
    const Span across = strip(-s_, c_, kBarWidth * r_, h);
    return {std::max(along.from, across.from), std::min(along.to, across.to)};
  }

 private:
  double c_, s_, r_;
};

std::uint8_t grey(double ball, double bar) {
  return static_cast<std::uint8_t>(
      std::max(0.0, PixelGrid::kBall * ball - (PixelGrid::kBall - PixelGrid::kBar) * bar) + 0.5);
}

int instants_of(const MotionBlur& smear, double half_diameter_px) {
  const double way =
      std::hypot(smear.x_px, smear.y_px) + kBarLength * half_diameter_px * std::abs(smear.turn_rad);
  return static_cast<int>(std::clamp(std::ceil(way / kSpacing_px), 1.0, double{kMaxInstants}));
}

}  // namespace

double PixelGrid::error_px(double r) {
  const double rounding = (8.0 * r + 8.0) / (2.0 * kBall);
  const double lines = 0.5 * std::sqrt(2.0 * r) / std::pow(kLines, 1.5);
  return (rounding + lines) * (r + 2.0) / (std::numbers::pi * r * r);
}

void PixelGrid::lay_out(const BallView& view, const MotionBlur& smear) {
  const double reach_px = std::max(view.along_px, view.across_px);
  const double x = reach_px + 0.5 * std::abs(smear.x_px) + 3.0;
  const double y = reach_px + 0.5 * std::abs(smear.y_px) + 3.0;
  left_ = static_cast<int>(std::floor(view.centre_px.x - x));
  bottom_ = static_cast<int>(std::floor(view.centre_px.y - y));
  width_ = static_cast<int>(std::ceil(view.centre_px.x + x)) - left_ + 1;
  height_ = static_cast<int>(std::ceil(view.centre_px.y + y)) - bottom_ + 1;
  pixels_.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), 0);
}

void PixelGrid::draw(const BallView& view, const MotionBlur& smear) {
  const double r = 0.5 * view.diameter_px();
  const EllipseCut ellipse(view);
  std::vector<BarCut> bars;
  const int instants = instants_of(smear, r);
  const auto part = [&](int k) { return (k + 0.5) / instants - 0.5; };
  for (int k = 0; k < instants; ++k) bars.emplace_back(view.equator_rad + part(k) * smear.turn_rad, r);
  const double weight = 1.0 / (kLines * instants);
  for (int row = 0; row < height_; ++row) {
    ball_.clear(static_cast<std::size_t>(width_));
    bar_.clear(static_cast<std::size_t>(width_));
    for (int k = 0; k < instants; ++k) {
      const double x = view.centre_px.x + part(k) * smear.x_px - (left_ - 0.5);
      const double y = view.centre_px.y + part(k) * smear.y_px - (bottom_ + row - 0.5);
      for (int line = 0; line < kLines; ++line) {
        const double h = (line + 0.5) / kLines - y;
        const Span ball = ellipse.at(h);
        ball_.add(x + ball.from, x + ball.to, weight);
        if (std::abs(h) > kBarReach * r) continue;
        const Span dark = bars[static_cast<std::size_t>(k)].at(h);
        bar_.add(x + dark.from, x + dark.to, weight);
      }
    }
    paint(pixels_.data() + static_cast<std::size_t>(row) * static_cast<std::size_t>(width_));
  }
}

void PixelGrid::paint(std::uint8_t* out) const {
  const bool nested = bar_.first() >= ball_.even_first() && bar_.end() <= ball_.even_end();
  double ball = 0.0;
  double dark = 0.0;
  std::size_t i = ball_.first();
  if (nested || bar_.empty()) {
    for (; i < ball_.even_first(); ++i) out[i] = grey(ball += ball_.step(i), 0.0);
    if (ball_.even_end() > i) {
      std::fill(out + i, out + ball_.even_end(), grey(ball, 0.0));
      for (std::size_t k = bar_.first(); k < bar_.end(); ++k) out[k] = grey(ball, dark += bar_.step(k));
      i = ball_.even_end();
    }
    for (; i < ball_.end(); ++i) out[i] = grey(ball += ball_.step(i), 0.0);
    return;
  }
  for (i = std::min(i, bar_.first()); i < std::max(ball_.end(), bar_.end()); ++i)
    out[i] = grey(ball += ball_.step(i), dark += bar_.step(i));
}

PixelGrid::Moments PixelGrid::brightness() const {
  const auto width = static_cast<std::size_t>(width_);
  Moments m;
  for (int row = 0; row < height_; ++row) {
    const std::uint8_t* line = pixels_.data() + static_cast<std::size_t>(row) * width;
    std::int64_t sum = 0, moment = 0;
    for (std::size_t i = 0; i < width; ++i) {
      sum += line[i];
      moment += static_cast<std::int64_t>(i) * line[i];
    }
    m.sum += static_cast<double>(sum);
    m.x += static_cast<double>(moment);
    m.y += static_cast<double>(sum) * row;
  }
  return m;
}

PixelGrid::Moments PixelGrid::darkness(double x0, double y0, double reach) const {
  const auto width = static_cast<std::size_t>(width_);
  Moments d;
  for (int row = 0; row < height_; ++row) {
    const double y = row - y0;
    const double square = reach * reach - y * y;
    if (square <= 0.0) continue;
    const double half = std::sqrt(square);
    const auto from = static_cast<std::size_t>(std::max(0.0, std::ceil(x0 - half)));
    const auto to = std::min(static_cast<std::size_t>(std::max(0.0, std::floor(x0 + half) + 1.0)), width);
    const std::uint8_t* line = pixels_.data() + static_cast<std::size_t>(row) * width;
    std::int64_t sum = 0, moment = 0, second = 0;
    for (std::size_t i = from; i < to; ++i) {
      const auto dark = static_cast<std::int64_t>(kBall - line[i]);
      const auto x = static_cast<std::int64_t>(i);
      sum += dark;
      moment += x * dark;
      second += x * x * dark;
    }
    const auto s = static_cast<double>(sum);
    const double m = static_cast<double>(moment) - x0 * s;
    d.sum += s;
    d.x += m;
    d.y += s * y;
    d.xx += static_cast<double>(second) - 2.0 * x0 * static_cast<double>(moment) + x0 * x0 * s;
    d.xy += m * y;
    d.yy += s * y * y;
  }
  return d;
}

PixelMeasurement PixelGrid::read(double half_diameter_px) const {
  const Moments m = brightness();
  // The bar is about the centre: it does not move it.
  const double x0 = m.x / m.sum;
  const double y0 = m.y / m.sum;
  const Moments d = darkness(x0, y0, kInside * half_diameter_px);
  const double area = m.sum + d.sum;
  PixelMeasurement out;
  out.centre_px = {left_ + x0 + d.x / area, bottom_ + y0 + d.y / area};
  out.diameter_px = 2.0 * std::sqrt(area / (kBall * std::numbers::pi));
  if (2.0 * half_diameter_px >= kSmallestWithLine_px && d.sum > 0.0)
    out.equator_rad = 0.5 * std::atan2(2.0 * (d.xy - d.x * d.y / d.sum),
                                       d.xx - d.x * d.x / d.sum - (d.yy - d.y * d.y / d.sum));
  return out;
}

PixelMeasurement PixelGrid::measure(const BallView& view, const MotionBlur& smear) {
  const double diameter = view.diameter_px();
  if (!(diameter >= kSmallest_px && diameter <= kLargest_px))
    return {view.centre_px, diameter, view.equator_rad};
  lay_out(view, smear);
  draw(view, smear);
  return read(0.5 * diameter);
}

}  // namespace strobe::sim
