#include "host/digitize/path/chance.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace strobe::digitize {
namespace {

double log_choose(std::size_t n, std::size_t k) {
  double sum = 0.0;
  for (std::size_t i = 1; i <= k; ++i)
    sum += std::log(static_cast<double>(n - k + i) / static_cast<double>(i));
  return sum;
}

/// ln of the probability of `least` or more successes of `trials`.
double log_tail(std::size_t trials, std::size_t least, double probability) {
  double sum = 0.0, first = -std::numeric_limits<double>::infinity();
  for (std::size_t k = least; k <= trials; ++k) {
    const double term = log_choose(trials, k) + static_cast<double>(k) * std::log(probability) +
                        static_cast<double>(trials - k) * std::log1p(-probability);
    if (k == least) first = term;
    sum += std::exp(term - first);
  }
  return std::min(0.0, first + std::log(sum));
}

}  // namespace

double log10_curves_by_chance(std::size_t points, std::size_t members, std::size_t parameters, double share) {
  assert(members <= points);
  if (members <= parameters) return std::numeric_limits<double>::infinity();
  const double probability = std::clamp(share, 1e-12, 0.5);
  // Every choice of the points that fix the curve, and every number of members, is a trial of its own.
  const double trials = std::log(static_cast<double>(points - parameters)) + log_choose(points, parameters);
  return (trials + log_tail(points - parameters, members - parameters, probability)) / std::log(10.0);
}

double share_of_view_per_px(std::span<const PathPoint> points, std::span<const int> eligible,
                            double diameter_px) {
  if (eligible.empty()) return 1.0;
  cv::Point2d least = point_at(points, eligible.front()).at, most = least;
  for (const int i : eligible) {
    const cv::Point2d at = point_at(points, i).at;
    least = {std::min(least.x, at.x), std::min(least.y, at.y)};
    most = {std::max(most.x, at.x), std::max(most.y, at.y)};
  }
  const double width = most.x - least.x + 2.0 * diameter_px, height = most.y - least.y + 2.0 * diameter_px;
  return (width + height) / (width * height);
}

}  // namespace strobe::digitize
