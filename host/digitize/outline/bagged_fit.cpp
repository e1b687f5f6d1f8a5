#include "host/digitize/outline/bagged_fit.hpp"

#include <algorithm>
#include <array>

namespace strobe::digitize {

namespace {

struct Sectors {
  double sectors_px, outside_px, inside_px;
};
// Lengths around the default, none a multiple of another, and depths from what the blur needs to twice that.
constexpr std::array<Sectors, 5> kVariants{
    {{8.0, 5.0, 8.0}, {5.0, 3.0, 4.0}, {6.5, 4.0, 6.0}, {10.0, 4.0, 6.0}, {12.0, 5.0, 5.0}}};

OutlineVector parameters(const OutlineShape& shape) {
  return {shape.centre.x, shape.centre.y, shape.radius, shape.oval_cos, shape.oval_sin};
}

/// Interquartile mean.
double interquartile_mean(std::vector<double> values) {
  std::ranges::sort(values);
  const std::size_t off = values.size() / 4;
  double sum = 0.0;
  for (std::size_t i = off; i < values.size() - off; ++i) sum += values[i];
  return sum / static_cast<double>(values.size() - 2 * off);
}

template <typename Value>
double mean_of(const std::vector<FittedOutline>& all, const Value& value) {
  std::vector<double> values;
  for (const FittedOutline& one : all) values.push_back(value(one));
  return interquartile_mean(std::move(values));
}

/// Mean of the fits' own covariances, and their scatter about the mean.
OutlineMatrix covariance_of(const std::vector<FittedOutline>& all, const OutlineShape& shape) {
  OutlineMatrix sum = OutlineMatrix::zeros();
  for (const FittedOutline& one : all) {
    const OutlineVector off = parameters(one.shape) - parameters(shape);
    sum += one.covariance + off * off.t();
  }
  return sum * (1.0 / static_cast<double>(all.size()));
}

}  // namespace

std::optional<FittedOutline> fit_outline_bagged(const Photograph& photograph, const LocalFrame& frame,
                                                const OutlineShape& start, double sigma_px,
                                                std::span<const OutlineShape> neighbours,
                                                const OutlineFitSettings& settings) {
  std::vector<FittedOutline> all;
  for (const Sectors& variant : kVariants) {
    OutlineFitSettings own = settings;
    own.sectors_px = variant.sectors_px;
    own.outside_px = variant.outside_px;
    own.inside_px = variant.inside_px;
    if (auto fitted = fit_outline(photograph, frame, start, sigma_px, neighbours, own))
      all.push_back(std::move(*fitted));
  }
  if (all.empty()) return std::nullopt;
  FittedOutline result = all.front();
  const auto of = [&](int a) {
    return mean_of(all, [a](const FittedOutline& one) { return parameters(one.shape)[a]; });
  };
  result.shape.centre = {of(0), of(1)};
  result.shape.radius = of(2);
  result.shape.oval_cos = of(3);
  result.shape.oval_sin = of(4);
  result.sigma_px = mean_of(all, [](const FittedOutline& one) { return one.sigma_px; });
  result.rms_px = mean_of(all, [](const FittedOutline& one) { return one.rms_px; });
  result.covariance = covariance_of(all, result.shape);
  return result;
}

}  // namespace strobe::digitize
