#include "host/digitize/outliers/spacing.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "host/digitize/core/statistics.hpp"

namespace strobe::digitize {
namespace {

constexpr std::size_t kMinImages = 4;
constexpr double kCloseOfStep = 0.5;
// A true image that another hides by half agrees with a ball's limb less well, under ambient light by a quarter.
constexpr double kClearDifference = 0.35;
// Of the median interval, where the flashes' times are not known: trains that tell their flashes apart by unequal
// intervals have none shorter, and neither lamp flashes that fast again. An outline that near to another borrows most
// of its limb, and its quality.
constexpr double kMinIntervalOfUnknown = 0.2;

class Leg {
 public:
  Leg(std::vector<int> members, bool curved, std::span<const PathPoint> points,
      std::span<const double> quality)
      : members_(std::move(members)), curved_(curved), points_(points), quality_(quality) {}

  /// Shortest interval of two flashes or more over the median one.
  static double shortest_interval(std::span<const double> times_s) {
    std::vector<double> steps;
    for (std::size_t k = 1; k < times_s.size(); ++k) steps.push_back(times_s[k] - times_s[k - 1]);
    const double least = *std::min_element(steps.begin(), steps.end());
    return least / median(std::move(steps));
  }

  /// Removes the worse image of the closest pair. Returns nullopt if none is too close.
  std::optional<TooClose> next(double shortest_interval) {
    if (members_.size() < kMinImages) return std::nullopt;
    const double typical = median_step();
    std::optional<TooClose> nearest;
    for (std::size_t k = 1; k < members_.size(); ++k) {
      const double apart = step(k);
      if (apart >= kCloseOfStep * typical || (nearest && apart >= nearest->distance_px)) continue;
      const auto pair = worse_first(members_[k - 1], members_[k]);
      const bool impossible = apart < kCloseOfStep * shortest_interval * typical;
      if (!impossible && quality_of(pair.second) - quality_of(pair.first) < kClearDifference) continue;
      nearest = TooClose{pair.first, pair.second, apart};
    }
    if (nearest) std::erase(members_, nearest->index);
    return nearest;
  }

 private:
  double quality_of(int i) const { return quality_[static_cast<std::size_t>(i)]; }
  const PathPoint& at(int i) const { return points_[static_cast<std::size_t>(i)]; }
  /// Gravity changes the speed along a curve, but not across the picture.
  double step(std::size_t k) const {
    const cv::Point2d step = at(members_[k]).at - at(members_[k - 1]).at;
    return curved_ ? std::abs(step.x) : cv::norm(step);
  }

  double median_step() const {
    std::vector<double> steps;
    for (std::size_t k = 1; k < members_.size(); ++k) steps.push_back(step(k));
    return median(std::move(steps));
  }

  std::pair<int, int> worse_first(int a, int b) const {
    const bool a_worse =
        quality_of(a) != quality_of(b) ? quality_of(a) < quality_of(b) : at(a).sd_px > at(b).sd_px;
    return a_worse ? std::pair(a, b) : std::pair(b, a);
  }

  std::vector<int> members_;
  bool curved_;
  std::span<const PathPoint> points_;
  std::span<const double> quality_;
};

}  // namespace

std::vector<TooClose> find_too_close(const Path& path, std::span<const PathPoint> points,
                                     std::span<const double> quality, std::span<const double> flash_times_s) {
  // Along a curve the ball may be slow, or seen from above itself.
  const double unknown = path.curved ? 0.0 : kMinIntervalOfUnknown;
  const double shortest_interval = flash_times_s.size() < 2 ? unknown : Leg::shortest_interval(flash_times_s);
  std::vector<TooClose> too_close;
  for (const auto& members : path.legs) {
    Leg leg(members, path.curved, points, quality);
    while (const auto next = leg.next(shortest_interval)) too_close.push_back(*next);
  }
  return too_close;
}

}  // namespace strobe::digitize
