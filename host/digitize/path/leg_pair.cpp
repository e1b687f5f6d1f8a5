#include "host/digitize/path/leg_pair.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "host/digitize/path/chance.hpp"

namespace strobe::digitize {
namespace {

// In diameters: how far the order of touchdown and lift-off may be wrong where the ball goes straight down and up.
constexpr double kCrossingNoise = 0.4;
constexpr double kNearApex = 3.0;
constexpr double kLegCost = 0.5;
constexpr double kLegCostBlind = 1.2;
constexpr double kMinSlope = 0.03;
// Without a surface one photograph in ten may have a second leg of what is no ball. A line at random meets the first
// leg's within kNearApex of its end in one of six photographs (18 diameters wide), begins within as much from there in
// one of six, and leads upwards in one of two.
constexpr double kMaxLog10SecondLegs = -1.0;
constexpr double kMeetByChance = 1.0 / 72.0;

class LegPair {
 public:
  LegPair(std::span<const PathPoint> points, std::span<const int> airborne, const PathContext& context)
      : points_(points),
        airborne_(airborne),
        context_(context),
        d_(context.diameter_px),
        share_per_px_(share_of_view_per_px(points, airborne, d_)) {}

  std::vector<LegLine> run(std::span<const LegLine> lines) const {
    if (lines.empty()) return {};
    double best = lines.front().weight;
    const LegLine* one = &lines.front();
    const LegLine* two = nullptr;
    const double cost = leg_cost(context_);
    for (std::size_t i = 0; i < lines.size(); ++i) {
      for (std::size_t j = i + 1; j < lines.size(); ++j) {
        if (lines[i].weight + lines[j].weight - cost <= best) break;
        const double weight = union_weight(lines[i], lines[j]) - cost;
        if (weight <= best || !belong_together(lines[i], lines[j])) continue;
        best = weight;
        one = &lines[i];
        two = &lines[j];
      }
    }
    return two == nullptr ? std::vector{*one} : std::vector{*one, *two};
  }

 private:
  bool belong_together(const LegLine& a, const LegLine& b) const {
    if (context_.surface_known) return meet_at_surface(a, b);
    return meet_somewhere(a, b) && log10_by_chance(a, b) < kMaxLog10SecondLegs;
  }

  bool meet_at_surface(const LegLine& a, const LegLine& b) const {
    auto ca = crossing(a, d_), cb = crossing(b, d_);
    if (!ca || !cb) return false;
    const double apart = std::abs(ca->x - cb->x);
    if (ca->side * cb->side > 0) return apart <= d_;
    if (ca->side > cb->side) std::swap(ca, cb);  // the left one first
    return cb->x - ca->x >= -kCrossingNoise * d_ && apart <= kLongestContact * d_;
  }

  /// Both legs go up from where their lines meet, and start near it.
  bool meet_somewhere(const LegLine& a, const LegLine& b) const {
    const double sine = a.along.cross(b.along);
    if (std::abs(sine) < 0.08) return false;
    const double s = (b.origin - a.origin).cross(b.along) / sine;
    const cv::Point2d apex = a.origin + s * a.along;
    for (const LegLine* leg : {&a, &b}) {
      const cv::Point2d far = far_end(points_, *leg, apex) - apex;
      if (far.y < kMinSlope * cv::norm(far)) return false;
      double nearest = std::numeric_limits<double>::infinity();
      for (const int i : leg->members) {
        const double place = (point_at(points_, i).at - apex).dot(far) / cv::norm(far);
        if (place < -0.3 * d_) return false;
        nearest = std::min(nearest, place);
      }
      if (nearest > kNearApex * d_) return false;
    }
    return true;
  }

  double union_weight(const LegLine& a, const LegLine& b) const {
    double weight = a.weight;
    for (const int i : b.members) {
      if (!std::binary_search(a.members.begin(), a.members.end(), i)) weight += point_at(points_, i).weight;
    }
    return weight;
  }

  /// How many legs like the second what the first leaves would make if it were no ball, log10.
  double log10_by_chance(const LegLine& one, const LegLine& two) const {
    std::vector<int> own, left;
    std::ranges::set_difference(two.members, one.members, std::back_inserter(own));
    std::ranges::set_difference(airborne_, one.members, std::back_inserter(left));
    if (own.size() <= kMinOwnImages)  // any two make a line
      return std::log10(0.5 * static_cast<double>(left.size() * (left.size() - 1)) * kMeetByChance);
    double off = kMinResidual_px;
    for (const int i : own) off = std::max(off, std::abs(two.off(point_at(points_, i).at)));
    const double share = 2.0 * off * share_per_px_;
    return log10_curves_by_chance(left.size(), own.size(), kMinOwnImages, share) + std::log10(kMeetByChance);
  }

  std::span<const PathPoint> points_;
  std::span<const int> airborne_;
  const PathContext& context_;
  double d_;
  double share_per_px_;  ///< of the view
};

}  // namespace

std::optional<Crossing> crossing(const LegLine& line, double diameter_px) {
  if (std::abs(line.along.y) < kMinSlope) return std::nullopt;
  const double s = (0.5 * diameter_px - line.origin.y) / line.along.y;
  const cv::Point2d up = line.along.y > 0 ? line.along : -line.along;
  return Crossing{line.origin.x + s * line.along.x, up.x > 0.03 ? 1.0 : up.x < -0.03 ? -1.0 : 0.0};
}

cv::Point2d far_end(std::span<const PathPoint> points, const LegLine& leg, cv::Point2d from) {
  cv::Point2d far = point_at(points, leg.members.front()).at;
  for (const int i : leg.members) {
    if (cv::norm(point_at(points, i).at - from) > cv::norm(far - from)) far = point_at(points, i).at;
  }
  return far;
}

double leg_cost(const PathContext& context) { return context.surface_known ? kLegCost : kLegCostBlind; }

std::vector<LegLine> choose_legs(std::span<const PathPoint> points, std::span<const int> airborne,
                                 std::span<const LegLine> lines, const PathContext& context) {
  return LegPair(points, airborne, context).run(lines);
}

}  // namespace strobe::digitize
