#include "host/digitize/edge_profile.hpp"

#include <array>
#include <cmath>
#include <numbers>

namespace strobe::digitize {

namespace {

// In units of sigma. Beyond the table's end the series of the blurred root is good to 1e-5.
constexpr double kLeast = -6.0;
constexpr double kMost = 10.0;
constexpr int kPerUnit = 64;
constexpr int kCells = static_cast<int>((kMost - kLeast) * kPerUnit);

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
      const double x = kLeast + static_cast<double>(i) / kPerUnit;
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
  const double at = (x - kLeast) * kPerUnit;
  const auto index = static_cast<std::size_t>(at);
  return {index, at - static_cast<double>(index)};
}

}  // namespace

Blurred blurred_step(double depth_px, double sigma_px) {
  const double x = depth_px / sigma_px;
  if (x <= kLeast) return {};
  if (x >= kMost) return {1.0, 0.0, 0.0};
  const Cell at = cell(x);
  const double slope = at.of(tables().density) / sigma_px;
  return {at.of(tables().step), slope, -x * slope};
}

Blurred blurred_root(double depth_px, double sigma_px) {
  const double x = depth_px / sigma_px;
  if (x <= kLeast) return {};
  const double scale = std::sqrt(sigma_px);
  double value = 0.0, slope = 0.0;
  if (x >= kMost) {
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

}  // namespace strobe::digitize
