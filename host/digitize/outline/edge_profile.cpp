#include "host/digitize/outline/edge_profile.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace strobe::digitize {

namespace {

// In units of sigma. Beyond the table's end the series of the blurred root is good to 1e-5.
constexpr double kMin = -6.0;
constexpr double kMax = 10.0;
constexpr int kPerUnit = 64;
constexpr int kCells = static_cast<int>((kMax - kMin) * kPerUnit);

double density(double x) { return std::exp(-0.5 * x * x) / std::sqrt(2.0 * std::numbers::pi); }

/// f(x) = ∫ sqrt(t) density(x - t) dt over t > 0, with t = u² to smooth the root; Simpson's rule.
double root_at(double x) {
  constexpr int kSteps = 400;
  const double end = std::sqrt(std::max(x, 0.0) + 8.0);
  const double h = end / kSteps;
  double sum = 0.0;
  for (int i = 0; i <= kSteps; ++i) {
    const double u = i * h;
    const double weight = i == 0 || i == kSteps ? 1.0 : (i % 2 != 0 ? 4.0 : 2.0);
    sum += weight * 2.0 * u * u * density(x - u * u);
  }
  return sum * h / 3.0;
}

struct Tables {
  std::array<double, kCells + 2> step{}, density{}, root{}, root_slope{};
  Tables() {
    constexpr double kSmall = 1e-4;
    for (int i = 0; i < kCells + 2; ++i) {
      const double x = kMin + static_cast<double>(i) / kPerUnit;
      const auto at = static_cast<std::size_t>(i);
      step[at] = 0.5 * std::erfc(-x / std::numbers::sqrt2);
      density[at] = digitize::density(x);
      root[at] = root_at(x);
      root_slope[at] = (root_at(x + kSmall) - root_at(x - kSmall)) / (2.0 * kSmall);
    }
  }
};

const Tables& tables() {
  static const Tables built;
  return built;
}

struct Cell {
  std::size_t index;
  double part;
  double of(const std::array<double, kCells + 2>& table) const {
    return table[index] + part * (table[index + 1] - table[index]);
  }
};

Cell cell(double x) {
  const double at = (x - kMin) * kPerUnit;
  const auto index = static_cast<std::size_t>(at);
  return {index, at - static_cast<double>(index)};
}

}  // namespace

BlurredValue blurred_step(double depth_px, double sigma_px) {
  const double x = depth_px / sigma_px;
  if (x <= kMin) return {};
  if (x >= kMax) return {1.0, 0.0, 0.0};
  const Cell at = cell(x);
  const double slope = at.of(tables().density) / sigma_px;
  return {at.of(tables().step), slope, -x * slope};
}

BlurredValue blurred_sqrt(double depth_px, double sigma_px) {
  const double x = depth_px / sigma_px;
  if (x <= kMin) return {};
  const double scale = std::sqrt(sigma_px);
  double value = 0.0, slope = 0.0;
  if (x >= kMax) {
    const double root = std::sqrt(x), inverse = 1.0 / (x * x);
    value = root * (1.0 - 0.125 * inverse);
    slope = (0.5 + 0.1875 * inverse) / root;
  } else {
    const Cell at = cell(x);
    value = at.of(tables().root);
    slope = at.of(tables().root_slope);
  }
  // sqrt(sigma)·f(s/sigma)
  return {scale * value, slope / scale, (0.5 * value - x * slope) / scale};
}

double inward_shift(double radius_px, double sigma_px) { return 0.5 * sigma_px * sigma_px / radius_px; }

namespace {
constexpr double kPerPixel = 16.0;

/// Foreshortened surface of a sphere towards the camera at that depth, over sqrt(2/R).
double sphere_factor(double depth, double radius) {
  return std::sqrt(std::max(0.25, 1.0 - 0.5 * depth / radius));
}

float lerp(float a, float b, float part) { return a + part * (b - a); }
}  // namespace

ProfileTable::ProfileTable(double sigma_px, double radius_px, double unit_px, double shallowest_px,
                           double deepest_px)
    : shallowest_(shallowest_px) {
  const auto count = static_cast<std::size_t>((deepest_px - shallowest_px) * kPerPixel) + 2;
  entries_.reserve(count);
  sums_.reserve(count);
  Sums sum{0.0, 0.0};
  for (std::size_t i = 0; i < count; ++i) {
    const double depth = shallowest_px + static_cast<double>(i) / kPerPixel;
    const BlurredValue step = blurred_step(depth, sigma_px), root = blurred_sqrt(depth, sigma_px);
    const double factor = sphere_factor(depth, radius_px) / std::sqrt(unit_px);
    entries_.push_back({static_cast<float>(step.value), static_cast<float>(root.value * factor),
                        static_cast<float>(step.by_depth), static_cast<float>(root.by_depth * factor),
                        static_cast<float>(step.by_sigma), static_cast<float>(root.by_sigma * factor)});
    if (i > 0) {
      sum.step += 0.5 / kPerPixel * (entries_[i - 1].step + entries_[i].step);
      sum.root += 0.5 / kPerPixel * (entries_[i - 1].root + entries_[i].root);
    }
    sums_.push_back(sum);
  }
}

double ProfileTable::position(double depth_px) const {
  return std::clamp((depth_px - shallowest_) * kPerPixel, 0.0,
                    static_cast<double>(entries_.size() - 1) - 1e-6);
}

ProfileTable::Entry ProfileTable::at(double depth_px) const {
  const double where = position(depth_px);
  const auto index = static_cast<std::size_t>(where);
  const auto part = static_cast<float>(where - static_cast<double>(index));
  const Entry &a = entries_[index], &b = entries_[index + 1];
  return {lerp(a.step, b.step, part),
          lerp(a.root, b.root, part),
          lerp(a.step_by_depth, b.step_by_depth, part),
          lerp(a.root_by_depth, b.root_by_depth, part),
          lerp(a.step_by_sigma, b.step_by_sigma, part),
          lerp(a.root_by_sigma, b.root_by_sigma, part)};
}

ProfileTable::Sums ProfileTable::sum_at(double position) const {
  const auto index = static_cast<std::size_t>(position);
  const double part = position - static_cast<double>(index);
  const Sums &a = sums_[index], &b = sums_[index + 1];
  return {a.step + part * (b.step - a.step), a.root + part * (b.root - a.root)};
}

ProfileTable::Mean ProfileTable::mean(double from_px, double to_px) const {
  const double low = position(std::min(from_px, to_px)), high = position(std::max(from_px, to_px));
  if (high - low < 1.0) {
    const Entry middle = at(0.5 * (from_px + to_px));
    return {middle.step, middle.root};
  }
  const Sums a = sum_at(low), b = sum_at(high);
  const double scale = kPerPixel / (high - low);
  return {static_cast<float>(scale * (b.step - a.step)), static_cast<float>(scale * (b.root - a.root))};
}

}  // namespace strobe::digitize
