#include "host/digitize/candidates/size_decision.hpp"

#include <algorithm>
#include <cmath>

#include "host/digitize/candidates/candidates.hpp"
#include "host/digitize/candidates/size_search.hpp"
#include "host/digitize/core/statistics.hpp"

namespace strobe::digitize {

namespace {

constexpr std::size_t kMinCertain = 2;
// A coarse radius is good to 3 %. Further from the size that is given, the balls' median is not that of all of them.
constexpr double kCentred = 0.03;
// A ball beyond the range is found at its end, give or take a coarse radius' error.
constexpr double kAtEnd = 0.01;
// Beyond the tolerance: sizes of circles, and of what is half out of the tolerance, are known to a few percent.
constexpr double kMargin = 0.05;
// The search nearby: a scale that is wrong by more is rare.
constexpr double kNear = 1.7;
// Of the votes for another size: with so many the given one has balls of its own, none of which votes for the other.
constexpr double kMinShareOfVotes = 0.5;
// One round thing of another size may be anything.
constexpr int kMinContradicting = 2;

/// On the photograph, where the lens may change the scale from place to place.
SearchRange search_range(const Photograph& photograph, const PlaneMap& map, double least_px, double most_px) {
  double least = 1e300, most = 0.0;
  for (const double u : {0.0, 0.5, 1.0}) {
    for (const double v : {0.0, 0.5, 1.0}) {
      const double scale = map.image_px_per_plane_px({u * photograph.width(), v * photograph.height()});
      least = std::min(least, scale);
      most = std::max(most, scale);
    }
  }
  SearchRange range;
  range.radius_min_px = std::max(3.01, 0.5 * least_px * least);
  range.radius_max_px = std::max(3.02, 0.5 * most_px * most);
  return range;
}

/// Diameters of the candidates that are balls without doubt [plane px].
std::vector<double> certain_sizes(const std::vector<Candidate>& candidates, const PlaneMap& map) {
  std::vector<double> sizes;
  for (const Candidate& c : candidates)
    if (c.score >= kCertainCoverage)
      sizes.push_back(2.0 * c.likeliest_radius_px / map.image_px_per_plane_px(c.centre_image));
  return sizes;
}

class Decider {
 public:
  Decider(const Photograph& photograph, const PlaneMap& map, const ExpectedSize& expected, Effort effort)
      : photograph_(photograph), map_(map), expected_(expected), effort_(effort) {}

  SizeDecision without_a_size() const {
    SizeDecision decision;
    const auto size = most_voted_size(find_whole_circles(photograph_), map_);
    if (size) search(decision, *size, std::max(expected_.tolerance, kSizeSpread) + kMargin);
    return decision;
  }

  SizeDecision with(double diameter_px) const {
    SizeDecision decision;
    search(decision, {.diameter_px = diameter_px, .least_px = diameter_px, .most_px = diameter_px},
           expected_.tolerance);
    if (is_sure(certain_sizes(decision.candidates, map_), diameter_px)) return decision;
    // Most wrong scales are not far off.
    const SearchRange near = search_range(photograph_, map_, diameter_px, diameter_px);
    if (!settle(decision, diameter_px,
                find_whole_circles(photograph_, 2.0 * near.radius_min_px / kNear,
                                   2.0 * near.radius_max_px * kNear)))
      settle(decision, diameter_px, find_whole_circles(photograph_));
    return decision;
  }

 private:
  /// Among sizes within the tolerance of the typical one, and all that voted for it.
  void search(SizeDecision& decision, const SizeVotes& size, double tolerance) const {
    decision.diameter_px = size.diameter_px;
    decision.least_px = std::min(size.diameter_px * (1.0 - tolerance), size.least_px * (1.0 - kMargin));
    decision.most_px = std::max(size.diameter_px * (1.0 + tolerance), size.most_px * (1.0 + kMargin));
    decision.candidates = find_candidates(
        photograph_, search_range(photograph_, map_, decision.least_px, decision.most_px), effort_);
  }

  /// Returns false if the circles say nothing.
  bool settle(SizeDecision& decision, double diameter_px, const std::vector<Candidate>& circles) const {
    const auto size = most_voted_size(circles, map_);
    if (!size) return false;
    const double least = diameter_px * (1.0 - expected_.tolerance - kMargin),
                 most = diameter_px * (1.0 + expected_.tolerance + kMargin);
    if (size->diameter_px >= least && size->diameter_px <= most) {
      search(decision, *size, expected_.tolerance + kMargin);
      return true;
    }
    if (size->circles < kMinContradicting ||
        votes_beside(*size, circles, map_, least, most) >= kMinShareOfVotes * size->votes)
      return false;
    decision.candidates.clear();
    decision.contradicted_by_px = size->diameter_px;
    return true;
  }

  /// Whether there are balls without doubt and none that may lie beyond the range.
  bool is_sure(const std::vector<double>& sizes, double diameter_px) const {
    const double inner = expected_.tolerance - kAtEnd;
    return sizes.size() >= kMinCertain && std::abs(median(sizes) / diameter_px - 1.0) <= kCentred &&
           std::ranges::all_of(sizes,
                               [&](double size) { return std::abs(size / diameter_px - 1.0) < inner; });
  }

  const Photograph& photograph_;
  const PlaneMap& map_;
  const ExpectedSize& expected_;
  Effort effort_;
};

}  // namespace

SizeDecision decide_size(const Photograph& photograph, const PlaneMap& map, const ExpectedSize& expected,
                         Effort effort) {
  const Decider decider(photograph, map, expected, effort);
  return expected.diameter_px ? decider.with(*expected.diameter_px) : decider.without_a_size();
}

}  // namespace strobe::digitize
