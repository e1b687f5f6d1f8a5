#include "host/digitize/outliers/ball_size.hpp"

#include <algorithm>
#include <cmath>

#include "host/digitize/core/statistics.hpp"

namespace strobe::digitize {
namespace {

constexpr std::size_t kMinForSlope = 5;
// A ball that is compressed, or lit from one side, may differ this much.
constexpr double kToleranceOfDiameter = 0.03;
constexpr double kTolerance_sd = 5.0;

double median_slope(std::span<const Outline> outlines) {
  std::vector<double> slopes;
  for (std::size_t i = 0; i < outlines.size(); ++i) {
    for (std::size_t j = i + 1; j < outlines.size(); ++j) {
      const double dx = outlines[j].centre.x - outlines[i].centre.x;
      if (std::abs(dx) < outlines[i].diameter) continue;
      slopes.push_back((outlines[j].diameter - outlines[i].diameter) / dx);
    }
  }
  return slopes.size() < kMinForSlope ? 0.0 : median(std::move(slopes));
}

double spread_about(std::span<const Outline> outlines, const SizeModel& size) {
  std::vector<double> off;
  for (const Outline& o : outlines) off.push_back(std::abs(o.diameter - size.at(o.centre.x)));
  return median(std::move(off));
}

SizeModel size_with_slope(std::span<const Outline> outlines, double slope) {
  std::vector<double> at_zero;
  for (const Outline& o : outlines) at_zero.push_back(o.diameter - slope * o.centre.x);
  return {median(std::move(at_zero)), slope, 0.0};
}

}  // namespace

SizeModel fit_size_model(std::span<const Outline> outlines) {
  SizeModel size = size_with_slope(outlines, 0.0);
  double spread = spread_about(outlines, size);
  if (outlines.size() >= kMinForSlope) {
    const SizeModel sloped = size_with_slope(outlines, median_slope(outlines));
    const double less = spread_about(outlines, sloped);
    if (less < 0.5 * spread) {
      size = sloped;
      spread = less;
    }
  }
  std::vector<double> sds;
  for (const Outline& o : outlines) sds.push_back(o.diameter_sd());
  const double own = median(sds), all = kSdOverMad * spread;
  size.spread = std::sqrt(std::max(0.0, all * all - own * own));
  // 1.25: the error of a median against that of a mean.
  size.sd = 1.25 * std::max(kSdOverMad * spread, median(std::move(sds))) /
            std::sqrt(static_cast<double>(outlines.size()));
  return size;
}

bool has_wrong_size(const Outline& outline, const SizeModel& size) {
  const double expected = size.at(outline.centre.x);
  const double allowed = std::max(kToleranceOfDiameter * expected,
                                  kTolerance_sd * std::hypot(outline.diameter_sd(), size.sd, size.spread));
  return std::abs(outline.diameter - expected) > allowed;
}

}  // namespace strobe::digitize
