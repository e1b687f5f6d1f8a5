#include "host/digitize/candidates/candidates.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "host/digitize/candidates/circle_search.hpp"
#include "host/digitize/candidates/edge_points.hpp"

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

/// A circle is fitted to the edges near a radius that is sought, and shading inside a ball makes some too: around the
/// same centre another radius may have more.
double likeliest_radius(const CircleSupport& support, const SupportedCircle& found) {
  constexpr double kMinMore = 0.02;  // more than a sector of 72
  double radius = found.circle.radius;
  if (found.coverage < kCertainCoverage) return radius;
  const double least = 0.75 * radius, most = 1.33 * radius;
  double coverage = found.coverage + kMinMore;
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

  EdgeDetection detection;
  detection.neighbourhood_px = radius;
  // A sixteenth of an 8-bit step per px: less is quantization.
  detection.floor = 0.0625 / 255.0;
  const auto edges = find_edge_points(reduced.intensity, detection);
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

}  // namespace strobe::digitize
