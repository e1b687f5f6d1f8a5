#include "host/digitize/candidates/circle_search.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>
#include <queue>

namespace strobe::digitize {

namespace {

/// Each edge point votes for the centres along its normal. The accumulator is wider than the picture, as a
/// ball's centre may be off it.
struct Votes {
  cv::Mat count;   // CV_32FC1
  int margin = 0;  // of the grid around the picture
};

Votes vote(const std::vector<EdgePoint>& edges, cv::Size size, double radius_min, double radius_max) {
  Votes votes;
  votes.margin = static_cast<int>(radius_max);
  votes.count = cv::Mat::zeros(size.height + 2 * votes.margin, size.width + 2 * votes.margin, CV_32FC1);
  const int steps = std::max(1, static_cast<int>(std::ceil(radius_max - radius_min)));
  const auto from = static_cast<float>(radius_min);
  const auto step = static_cast<float>((radius_max - radius_min) / steps);
  const float shift = static_cast<float>(votes.margin) + 0.5F;
  for (const auto& edge : edges) {
    for (int i = 0; i <= steps; ++i) {
      const float r = from + static_cast<float>(i) * step;
      const int x = static_cast<int>(edge.at.x + r * edge.normal.x + shift);
      const int y = static_cast<int>(edge.at.y + r * edge.normal.y + shift);
      if (x >= 0 && y >= 0 && x < votes.count.cols && y < votes.count.rows)
        votes.count.at<float>(y, x) += 1.0F;
    }
  }
  const double spread = 0.05 * radius_max;
  cv::GaussianBlur(votes.count, votes.count, {}, spread, spread, cv::BORDER_CONSTANT);
  return votes;
}

struct Peak {
  cv::Point2d at;
  float height = 0.0F;
};

/// Local maxima, highest first.
std::vector<Peak> peaks_of(const Votes& votes, double radius, std::size_t most) {
  cv::Mat around;
  const int side = 2 * std::max(1, static_cast<int>(0.05 * radius)) + 1;
  cv::dilate(votes.count, around, cv::getStructuringElement(cv::MORPH_RECT, {side, side}));
  std::vector<Peak> peaks;
  for (int y = 0; y < votes.count.rows; ++y) {
    const auto* count = votes.count.ptr<float>(y);
    const auto* top = around.ptr<float>(y);
    for (int x = 0; x < votes.count.cols; ++x)
      if (count[x] > 0.0F && count[x] == top[x])
        peaks.push_back({cv::Point2d(x - votes.margin, y - votes.margin), count[x]});
  }
  std::stable_sort(peaks.begin(), peaks.end(),
                   [](const Peak& a, const Peak& b) { return a.height > b.height; });
  if (peaks.size() > most) peaks.resize(most);
  return peaks;
}

struct Scored {
  SupportedCircle supported;
  std::size_t round = 0;  ///< number of circles found when it was fitted
  std::size_t peak = 0;
  bool operator<(const Scored& other) const {
    if (supported.coverage != other.supported.coverage) return supported.coverage < other.supported.coverage;
    return peak > other.peak;
  }
};

/// How far from a circle edge points may change its fit [px].
constexpr double kFitReach = 16.0;

/// Greedy: the circle with the largest coverage claims its edge points, then the next by what is left.
std::vector<SupportedCircle> best_first(CircleSupport& edges, const std::vector<Peak>& peaks,
                                        double radius_min, double radius_max, double min_coverage) {
  const double middle = 0.5 * (radius_min + radius_max);
  std::vector<SupportedCircle> fitted(peaks.size());
  cv::parallel_for_(cv::Range(0, static_cast<int>(peaks.size())), [&](const cv::Range& range) {
    for (auto i = static_cast<std::size_t>(range.start); i < static_cast<std::size_t>(range.end); ++i)
      fitted[i] = edges.fit({peaks[i].at, middle}, radius_min, radius_max);
  });
  std::priority_queue<Scored> queue;
  for (std::size_t i = 0; i < peaks.size(); ++i)
    if (fitted[i].coverage >= min_coverage) queue.push({fitted[i], 0, i});
  std::vector<SupportedCircle> found;
  // A circle found since its fit may have claimed its edge points.
  const auto outdated = [&](const Scored& scored) {
    return std::any_of(found.begin() + static_cast<std::ptrdiff_t>(scored.round), found.end(),
                       [&](const SupportedCircle& other) {
                         return cv::norm(other.circle.centre - scored.supported.circle.centre) <
                                2.0 * radius_max + kFitReach;
                       });
  };
  while (!queue.empty()) {
    Scored best = queue.top();
    queue.pop();
    if (outdated(best)) {
      best.supported = edges.fit(best.supported.circle, radius_min, radius_max);
      best.round = found.size();
      if (best.supported.coverage >= min_coverage) queue.push(best);
      continue;
    }
    const Circle& circle = best.supported.circle;
    const bool near = std::any_of(found.begin(), found.end(), [&](const SupportedCircle& other) {
      return cv::norm(other.circle.centre - circle.centre) < 0.1 * middle;
    });
    if (near) continue;
    edges.claim(circle);
    found.push_back(best.supported);
  }
  return found;
}

}  // namespace

std::vector<SupportedCircle> find_circles(const std::vector<EdgePoint>& edges, CircleSupport& support,
                                          cv::Size size, const CircleSearch& search) {
  const Votes votes = vote(edges, size, search.radius_min, search.radius_max);
  const auto peaks = peaks_of(votes, 0.5 * (search.radius_min + search.radius_max), search.max_peaks);
  return best_first(support, peaks, search.radius_min, search.radius_max, search.min_coverage);
}

}  // namespace strobe::digitize
