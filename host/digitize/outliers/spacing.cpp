#include "host/digitize/outliers/spacing.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "host/digitize/core/median.hpp"

namespace strobe::digitize {
namespace {

constexpr std::size_t kFewest = 4;
constexpr double kNearOfStep = 0.5;
// Merits of true images differ by this much at most where nothing is saturated.
constexpr double kClearlyLess = 0.2;

class Leg {
 public:
  Leg(std::vector<int> members, std::span<const PathPoint> points, std::span<const double> quality)
      : members_(std::move(members)), points_(points), merit_(quality) {}

  /// The least distance of two images by the flashes' times, over the usual one.
  static double least_step(std::span<const double> times_s) {
    std::vector<double> steps;
    for (std::size_t k = 1; k < times_s.size(); ++k) steps.push_back(times_s[k] - times_s[k - 1]);
    if (steps.empty()) return 0.0;
    const double least = *std::min_element(steps.begin(), steps.end());
    return least / median(std::move(steps));
  }

  /// Takes out the worst of the nearest pair; nothing: there is none.
  std::optional<TooClose> next(double least_step) {
    if (members_.size() < kFewest) return std::nullopt;
    const double usual = usual_step();
    std::optional<TooClose> nearest;
    for (std::size_t k = 1; k < members_.size(); ++k) {
      const double apart = step(k);
      if (apart >= kNearOfStep * usual || (nearest && apart >= nearest->apart_px)) continue;
      const auto pair = worse_first(members_[k - 1], members_[k]);
      const bool impossible = apart < kNearOfStep * least_step * usual;
      if (!impossible && merit_of(pair.second) - merit_of(pair.first) < kClearlyLess) continue;
      nearest = TooClose{pair.first, pair.second, apart};
    }
    if (nearest) std::erase(members_, nearest->index);
    return nearest;
  }

 private:
  double merit_of(int i) const { return merit_[static_cast<std::size_t>(i)]; }
  const PathPoint& at(int i) const { return points_[static_cast<std::size_t>(i)]; }
  double step(std::size_t k) const { return cv::norm(at(members_[k]).at - at(members_[k - 1]).at); }

  double usual_step() const {
    std::vector<double> steps;
    for (std::size_t k = 1; k < members_.size(); ++k) steps.push_back(step(k));
    return median(std::move(steps));
  }

  std::pair<int, int> worse_first(int a, int b) const {
    const bool a_worse = merit_of(a) != merit_of(b) ? merit_of(a) < merit_of(b) : at(a).sd_px > at(b).sd_px;
    return a_worse ? std::pair(a, b) : std::pair(b, a);
  }

  std::vector<int> members_;
  std::span<const PathPoint> points_;
  std::span<const double> merit_;
};

}  // namespace

std::vector<TooClose> find_too_close(const Path& path, std::span<const PathPoint> points,
                                     std::span<const double> quality, std::span<const double> flash_times_s) {
  const double least_step = Leg::least_step(flash_times_s);
  std::vector<TooClose> too_close;
  for (const auto& members : path.legs) {
    Leg leg(members, points, quality);
    while (const auto next = leg.next(least_step)) too_close.push_back(*next);
  }
  return too_close;
}

}  // namespace strobe::digitize
