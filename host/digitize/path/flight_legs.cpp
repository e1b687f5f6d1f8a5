#include "host/digitize/path/flight_legs.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "host/digitize/path/chance.hpp"
#include "host/digitize/path/leg_line.hpp"

namespace strobe::digitize {
namespace {

using Shape = FlightCurve::Shape;

// One leg in a thousand photographs may be made of what is no ball.
constexpr double kMaxLog10ByChance = -3.0;
// A seed is three images among so many neighbours of the first and the second: some are hidden, some are none.
constexpr std::size_t kNeighbours = 4;
// The next image of a leg is within so many of its longest step: trains have unequal intervals, images are hidden.
constexpr double kLongestGap = 4.0;
constexpr double kAllowed_sd = 3.0;
// A curve known no better than this share of a diameter predicts no image.
constexpr double kVagueOfDiameter = 0.5;
constexpr double kMinAsideOfDiameter = 0.05;
// How far a bounce may be from between its legs' images, and above touching the surface.
constexpr double kBounceNoise = 0.4;

class LegSearch {
 public:
  LegSearch(std::span<const PathPoint> points, std::span<const int> eligible, const PathContext& context)
      : points_(points), context_(context), d_(context.diameter_px), free_(eligible.begin(), eligible.end()) {
    std::ranges::sort(free_, {}, [this](int i) { return at(i).x; });
    share_per_px_ = share_of_view_per_px(points_, free_, d_);
  }

  std::vector<FlightLeg> run() {
    while (auto leg = next()) {
      std::erase_if(free_, [&](int i) { return has(leg->members, i); });
      const auto after =
          std::ranges::find_if(legs_, [&](const FlightLeg& l) { return first_x(l) > first_x(*leg); });
      legs_.insert(after, std::move(*leg));
    }
    return std::move(legs_);
  }

 private:
  struct Candidate {
    FlightLeg leg;
    double log10_chance;
  };

  cv::Point2d at(int i) const { return point_at(points_, i).at; }
  static bool has(const std::vector<int>& members, int i) {
    return std::ranges::find(members, i) != members.end();
  }
  double first_x(const FlightLeg& leg) const { return at(leg.members.front()).x; }
  double last_x(const FlightLeg& leg) const { return at(leg.members.back()).x; }

  std::optional<FlightLeg> next() const {
    std::vector<Candidate> candidates;
    for (std::size_t i = 0; i < free_.size(); ++i) {
      for (std::size_t j = i + 1; j < std::min(free_.size(), i + 1 + kNeighbours); ++j) {
        for (std::size_t k = j + 1; k < std::min(free_.size(), j + 1 + kNeighbours); ++k)
          grow({free_[i], free_[j], free_[k]}, candidates);
      }
    }
    std::ranges::stable_sort(candidates, {}, &Candidate::log10_chance);
    for (Candidate& c : candidates)
      if (fits_in(c.leg)) return std::move(c.leg);
    return std::nullopt;
  }

  double allowed_off(int i, const FlightCurve& curve) const {
    return leg_tolerance(point_at(points_, i), d_) + kAllowed_sd * curve.sd(at(i));
  }

  double longest_step(const std::vector<int>& members) const {
    double longest = 0.0;
    for (std::size_t k = 1; k < members.size(); ++k)
      longest = std::max(longest, cv::norm(at(members[k]) - at(members[k - 1])));
    return longest;
  }

  /// The nearest image that the curve leads to.
  std::optional<int> nearest_on(const FlightCurve& curve, const std::vector<int>& members) const {
    double least = kLongestGap * longest_step(members);
    std::optional<int> nearest;
    for (const int i : free_) {
      if (has(members, i) || kAllowed_sd * curve.sd(at(i)) > kVagueOfDiameter * d_) continue;
      if (std::abs(curve.off(at(i))) > allowed_off(i, curve)) continue;
      double apart = std::numeric_limits<double>::infinity(), aside = apart;
      for (const int m : members) {
        apart = std::min(apart, cv::norm(at(m) - at(i)));
        aside = std::min(aside, std::abs(at(m).x - at(i).x));
      }
      if (apart > least || aside < kMinAsideOfDiameter * d_) continue;
      least = apart;
      nearest = i;
    }
    return nearest;
  }

  void grow(std::vector<int> members, std::vector<Candidate>& candidates) const {
    for (std::size_t k = 1; k < members.size(); ++k)
      if (at(members[k]).x - at(members[k - 1]).x < kMinAsideOfDiameter * d_) return;
    const bool known = std::ranges::any_of(candidates, [&](const Candidate& c) {
      return std::ranges::all_of(members, [&](int i) { return has(c.leg.members, i); });
    });
    if (known) return;
    auto curve = FlightCurve::fit(points_, members, d_);
    while (curve) {
      const auto more = nearest_on(*curve, members);
      if (!more) break;
      members.push_back(*more);
      std::ranges::sort(members, {}, [this](int i) { return at(i).x; });
      curve = FlightCurve::fit(points_, members, d_);
    }
    if (!curve) return;
    const double log10_chance = by_chance(members);
    if (log10_chance > kMaxLog10ByChance) return;
    FlightLeg leg{*curve, std::move(members), 0.0};
    for (const int i : leg.members) leg.weight += point_at(points_, i).weight;
    candidates.push_back({std::move(leg), log10_chance});
  }

  /// With the shape that is the least likely by chance.
  double by_chance(const std::vector<int>& members) const {
    double least = std::numeric_limits<double>::infinity();
    for (const Shape shape : {Shape::line, Shape::parabola, Shape::conic}) {
      const auto curve = FlightCurve::fit(points_, members, d_, shape);
      if (!curve) continue;
      double off = kMinResidual_px;
      for (const int i : members) off = std::max(off, std::abs(curve->off(at(i))));
      const double share = 2.0 * off * share_per_px_;
      // Three shapes are tried.
      least =
          std::min(least, std::log10(3.0) + log10_curves_by_chance(free_.size(), members.size(),
                                                                   static_cast<std::size_t>(shape), share));
    }
    return least;
  }

  bool fits_in(const FlightLeg& leg) const {
    for (std::size_t k = 0; k <= legs_.size(); ++k) {
      const FlightLeg* before = k > 0 ? &legs_[k - 1] : nullptr;
      const FlightLeg* after = k < legs_.size() ? &legs_[k] : nullptr;
      if ((before == nullptr || joined(*before, leg)) && (after == nullptr || joined(leg, *after)))
        return true;
    }
    return false;
  }

  /// The left leg falls towards the right one, which rises, and they cross between their images.
  bool joined(const FlightLeg& left, const FlightLeg& right) const {
    if (last_x(left) > first_x(right) + kBounceNoise * d_) return false;
    double from = last_x(left) - kBounceNoise * d_, to = first_x(right) + kBounceNoise * d_;
    const auto above = [&](double x) -> std::optional<double> {
      const auto l = left.curve.height(x), r = right.curve.height(x);
      return l && r ? std::optional(*l - *r) : std::nullopt;
    };
    const auto start = above(from), end = above(to);
    if (!start || !end || *start < 0.0 || *end > 0.0) return false;
    for (int round = 0; round < 40; ++round) {
      const double middle = 0.5 * (from + to);
      const auto there = above(middle);
      if (!there) return false;
      (*there > 0.0 ? from : to) = middle;
    }
    const auto falls = left.curve.slope(from), rises = right.curve.slope(from);
    if (!falls || !rises || *falls >= 0.0 || *rises <= 0.0) return false;
    return !context_.surface_known || *left.curve.height(from) <= (0.5 + kBounceNoise) * d_;
  }

  std::span<const PathPoint> points_;
  const PathContext& context_;
  double d_;
  std::vector<int> free_;  ///< by x
  std::vector<FlightLeg> legs_;
  double share_per_px_ = 1.0;
};

}  // namespace

std::vector<FlightLeg> flight_legs(std::span<const PathPoint> points, std::span<const int> eligible,
                                   const PathContext& context) {
  return LegSearch(points, eligible, context).run();
}

}  // namespace strobe::digitize
