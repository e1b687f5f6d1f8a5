#include "host/digitize/candidates/size_search.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "host/digitize/candidates/circle_search.hpp"
#include "host/digitize/candidates/edge_points.hpp"

namespace strobe::digitize {

namespace {

constexpr double kMinRadius_px = 10.0;
constexpr double kMaxRadiusOfSide = 0.3;
// Of a downsampled picture: an edge counts for a circle within 1.5 px, which should be a few percent of the radius.
constexpr double kReducedRadius_px = 20.0;
// Of the radii that one search votes for: the votes of a wider range mix with those of other sizes. Ranges overlap,
// as a radius is fitted within its own.
const double kBand = std::cbrt(2.0);
constexpr double kOverlap = 1.06;
constexpr double kMinCoverage = 0.5;
constexpr std::size_t kMaxPeaks = 100;
constexpr double kMinVotes = 0.5;  // a circle seen for three quarters

EdgeDetection detection_for(double radius) {
  EdgeDetection detection;
  detection.neighbourhood_px = radius;
  detection.floor = 0.0625 / 255.0;  // as of candidates
  return detection;
}

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

double diameter_of(const Candidate& circle, const PlaneMap& map) {
  return 2.0 * circle.radius_image_px / map.image_px_per_plane_px(circle.centre_image);
}

}  // namespace

double whole_circle_vote(const Candidate& circle) {
  return std::max(0.0, (circle.score - kMinCoverage) / (1.0 - kMinCoverage));
}

std::vector<Candidate> find_whole_circles(const Photograph& photograph, double least_px, double most_px) {
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

}  // namespace strobe::digitize
