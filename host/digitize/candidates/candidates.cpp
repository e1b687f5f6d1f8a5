#include "host/digitize/candidates/candidates.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <span>

#include "host/digitize/candidates/circle_search.hpp"
#include "host/digitize/core/statistics.hpp"

namespace strobe::digitize {

namespace {

/// The photograph, downsampled by a whole number to the ball's radius that the search needs.
struct Reduced {
  cv::Mat intensity;
  int factor = 1;
  double to_full(double at) const { return (at + 0.5) * factor - 0.5; }
};

Reduced downsample(const cv::Mat& intensity, double radius_px, Effort effort) {
  const double wanted = effort == Effort::fast ? 25.0 : 32.0;
  Reduced reduced;
  reduced.factor = std::max(1, static_cast<int>(radius_px / wanted));
  reduced.factor = std::min(reduced.factor, std::min(intensity.cols, intensity.rows));
  if (reduced.factor == 1) {
    reduced.intensity = intensity;
    return reduced;
  }
  const int f = reduced.factor;
  const cv::Size size(intensity.cols / f, intensity.rows / f);
  cv::resize(intensity(cv::Rect(0, 0, size.width * f, size.height * f)), reduced.intensity, size, 0, 0,
             cv::INTER_AREA);
  return reduced;
}

EdgeDetection detection_for(double radius) {
  EdgeDetection detection;
  detection.neighbourhood_px = radius;
  // A sixteenth of an 8-bit step per px: less is quantization.
  detection.floor = 1.0 / 16.0 / 255.0;
  return detection;
}

/// Circles seen for this much are balls: texture, seams and shadows support half of a circle at most, and
/// chance another tenth.
inline constexpr double kCertainCoverage = 0.65;

/// A circle is fitted to the edges near a radius that is sought, and shading inside a ball makes some too:
/// around the same centre another radius may have more.
double likeliest_radius(const CircleSupport& support, const SupportedCircle& found) {
  double radius = found.circle.radius;
  if (found.coverage < kCertainCoverage) return radius;
  const double least = 0.75 * radius, most = 1.33 * radius;
  double coverage = found.coverage + 1.5 * kSectorOfCircle;  // more than a sector
  for (const double factor : {0.8, 0.9, 1.1, 1.2}) {
    const auto other = support.fit({found.circle.centre, factor * found.circle.radius}, least, most);
    if (other.coverage <= coverage ||
        cv::norm(other.circle.centre - found.circle.centre) > 0.2 * found.circle.radius)
      continue;
    coverage = other.coverage;
    radius = other.circle.radius;
  }
  return radius;
}

}  // namespace

std::vector<Candidate> find_candidates(const Photograph& photograph, const SearchRange& range,
                                       Effort effort) {
  const double largest = std::max(photograph.width(), photograph.height());
  if (!(range.radius_min_px > 3.0 && range.radius_max_px >= range.radius_min_px) ||
      range.radius_max_px > largest)
    return {};
  const double middle = 0.5 * (range.radius_min_px + range.radius_max_px);
  const Reduced reduced = downsample(photograph.intensity, middle, effort);
  if (std::min(reduced.intensity.cols, reduced.intensity.rows) < 3) return {};
  const double radius_min = range.radius_min_px / reduced.factor,
               radius_max = range.radius_max_px / reduced.factor;
  const double radius = middle / reduced.factor;

  const auto edges = find_edge_points(reduced.intensity, detection_for(radius));
  const cv::Size size = reduced.intensity.size();
  CircleSupport support(edges, size);
  const auto circles = find_circles(edges, support, size, {radius_min, radius_max, range.min_coverage});
  support.release();

  std::vector<Candidate> candidates;
  // A few tell whether the size is right.
  constexpr std::size_t kJudged = 6;
  for (const auto& found : circles) {
    const Circle& circle = found.circle;
    candidates.push_back(
        {{reduced.to_full(circle.centre.x), reduced.to_full(circle.centre.y)},
         circle.radius * reduced.factor,
         found.coverage,
         (candidates.size() < kJudged ? likeliest_radius(support, found) : circle.radius) * reduced.factor});
  }
  // A refit may have increased the coverage.
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.score > b.score; });
  return candidates;
}

namespace {

// The ball's size on a photograph of unknown scale: circles of any size are sought, and those that are seen
// for more than half of their circumference vote for theirs. Arcs of several things, texture and what is
// drawn on a ball support less than that of a circle. Deterministic for any number of threads; thread-safe;
// allocates.

constexpr double kMinRadius_px = 10.0;
// What is larger may be the circle that a lens lights.
constexpr double kMaxRadiusOfSide = 0.3;
// Of a downsampled picture: an edge counts for a circle within 1.5 px, which should be a few percent of the
// radius.
constexpr double kReducedRadius_px = 20.0;
// Of the radii that one search votes for: the votes of a wider range mix with those of other sizes. Ranges
// overlap, as a radius is fitted within its own.
const double kBand = std::cbrt(2.0);
constexpr double kOverlap = 1.06;
constexpr double kMinCoverage = 0.5;
constexpr std::size_t kMaxPeaks = 100;
constexpr double kMinVotes = 0.5;  // a circle seen for three quarters

/// Searches one downsampling for radii from `radius` to twice that.
void search_octave(const cv::Mat& intensity, double radius, double largest, int factor,
                   std::vector<Candidate>& found) {
  const auto edges = find_edge_points(intensity, detection_for(radius * kBand));
  CircleSupport support(edges, intensity.size());
  const double end = std::min(2.0 * radius, largest);
  for (double from = radius; from < end * 0.999; from *= kBand) {
    const CircleSearch search{from / kOverlap, std::min(from * kBand * kOverlap, largest), kMinCoverage,
                              kMaxPeaks};
    for (const auto& [circle, coverage] : find_circles(edges, support, intensity.size(), search))
      found.push_back({{(circle.centre.x + 0.5) * factor - 0.5, (circle.centre.y + 0.5) * factor - 0.5},
                       circle.radius * factor,
                       coverage,
                       circle.radius * factor});
    support.release();
  }
}

/// The same circle is found in neighbouring ranges of radii.
std::vector<Candidate> without_repetitions(std::vector<Candidate> circles) {
  std::ranges::stable_sort(circles, std::ranges::greater{}, &Candidate::score);
  std::vector<Candidate> kept;
  for (const Candidate& circle : circles) {
    const bool known = std::ranges::any_of(kept, [&](const Candidate& other) {
      const double larger = std::max(circle.radius_image_px, other.radius_image_px);
      return cv::norm(circle.centre_image - other.centre_image) < 0.5 * larger &&
             std::min(circle.radius_image_px, other.radius_image_px) > 0.7 * larger;
    });
    if (!known) kept.push_back(circle);
  }
  return kept;
}

/// Real sizes on one photograph differ by ±10 %, as the path comes nearer.
constexpr double kSizeSpread = 0.12;

struct SizeVotes {
  double diameter_px = 0.0;              ///< plane px
  double votes = 0.0;                    ///< of the circles whose size is within kSizeSpread of it
  int circles = 0;                       ///< that voted for it
  double least_px = 0.0, most_px = 0.0;  ///< their diameters
};

double diameter_of(const Candidate& circle, const PlaneMap& map) {
  return 2.0 * circle.radius_image_px / map.image_px_per_plane_px(circle.centre_image);
}

/// A circle's vote: 0 for half of it seen or less, 1 for all.
double whole_circle_vote(const Candidate& circle) {
  return std::max(0.0, (circle.score - kMinCoverage) / (1.0 - kMinCoverage));
}

/// Circles that have a vote, best first, with diameters from `least_px` or less to `most_px` [image px], but
/// at least 20 px and at most .6 of the photograph's shorter side. Radii are good to 3 %.
std::vector<Candidate> find_whole_circles(const Photograph& photograph, double least_px = 0.0,
                                          double most_px = 1e9) {
  const double side = std::min(photograph.width(), photograph.height());
  const double largest = std::min(kMaxRadiusOfSide * side, 0.5 * most_px);
  std::vector<Candidate> found;
  cv::Mat intensity = photograph.intensity;
  int factor = 1;
  double first = kMinRadius_px;
  while (4.0 * first <= least_px) first *= 2.0;
  for (double radius = first; radius < largest; radius *= 2.0) {
    while (radius / factor >= 2.0 * kReducedRadius_px) {
      const cv::Size half(intensity.cols / 2, intensity.rows / 2);
      cv::Mat smaller;
      cv::resize(intensity(cv::Rect(0, 0, 2 * half.width, 2 * half.height)), smaller, half, 0, 0,
                 cv::INTER_AREA);
      intensity = smaller;
      factor *= 2;
    }
    search_octave(intensity, radius / factor, largest / factor, factor, found);
  }
  return without_repetitions(std::move(found));
}

/// The size with the most votes. Returns nullopt if none has as many as one circle seen for three quarters.
std::optional<SizeVotes> most_voted_size(std::span<const Candidate> circles, const PlaneMap& map) {
  const double reach = std::log1p(kSizeSpread);
  SizeVotes best;
  double most = 0.0;
  for (const Candidate& centre : circles) {
    const double size = diameter_of(centre, map);
    double sum = 0.0;  // less for sizes further off, so that the middle of a range has the most
    for (const Candidate& circle : circles)
      sum += whole_circle_vote(circle) *
             std::max(0.0, 1.0 - std::abs(std::log(diameter_of(circle, map) / size)) / reach);
    if (sum > most) most = sum, best.diameter_px = size;
  }
  if (!(most > 0.0)) return std::nullopt;
  const double around = best.diameter_px;
  double sum = 0.0;
  for (const Candidate& circle : circles) {
    const double size = diameter_of(circle, map), vote = whole_circle_vote(circle);
    if (!(vote > 0.0) || std::abs(std::log(size / around)) > reach) continue;
    best.votes += vote;
    sum += vote * size;
    best.least_px = best.circles > 0 ? std::min(best.least_px, size) : size;
    best.most_px = std::max(best.most_px, size);
    ++best.circles;
  }
  if (best.votes < kMinVotes) return std::nullopt;
  best.diameter_px = sum / best.votes;
  return best;
}

/// Votes for diameters from `min_px` to `max_px` [plane px] by circles that did not vote for the other size.
double votes_beside(const SizeVotes& other, std::span<const Candidate> circles, const PlaneMap& map,
                    double min_px, double max_px) {
  double votes = 0.0;
  for (const Candidate& circle : circles) {
    const double size = diameter_of(circle, map);
    if (size >= other.least_px && size <= other.most_px) continue;
    if (size >= min_px && size <= max_px) votes += whole_circle_vote(circle);
  }
  return votes;
}

constexpr std::size_t kMinCertain = 2;
// A coarse radius is good to 3 %. Further from the size that is given, the balls' median is not that of all
// of them.
constexpr double kCentred = 0.03;
// A ball beyond the range is found at its end, give or take a coarse radius' error.
constexpr double kAtEnd = 0.01;
// Beyond the tolerance: sizes of circles, and of what is half out of the tolerance, are known to a few
// percent.
constexpr double kSizeMargin = 0.05;
// The search nearby: a scale that is wrong by more is rare.
constexpr double kNear = 1.7;
// Of the votes for another size: with so many the given one has balls of its own, none of which votes for the
// other.
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
    if (size) search(decision, *size, std::max(expected_.tolerance, kSizeSpread) + kSizeMargin);
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
    decision.least_px = std::min(size.diameter_px * (1.0 - tolerance), size.least_px * (1.0 - kSizeMargin));
    decision.most_px = std::max(size.diameter_px * (1.0 + tolerance), size.most_px * (1.0 + kSizeMargin));
    decision.candidates = find_candidates(
        photograph_, search_range(photograph_, map_, decision.least_px, decision.most_px), effort_);
  }

  /// Returns false if the circles say nothing.
  bool settle(SizeDecision& decision, double diameter_px, const std::vector<Candidate>& circles) const {
    const auto size = most_voted_size(circles, map_);
    if (!size) return false;
    const double least = diameter_px * (1.0 - expected_.tolerance - kSizeMargin),
                 most = diameter_px * (1.0 + expected_.tolerance + kSizeMargin);
    if (size->diameter_px >= least && size->diameter_px <= most) {
      // What was told says which sizes are balls', too.
      search(decision,
             {.diameter_px = size->diameter_px,
              .least_px = std::min(size->least_px, diameter_px * (1.0 - expected_.tolerance)),
              .most_px = std::max(size->most_px, diameter_px * (1.0 + expected_.tolerance))},
             expected_.tolerance + kSizeMargin);
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
