#include "host/digitize/candidates/circle_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <numbers>
#include <numeric>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>
#include <queue>

namespace strobe::digitize {

namespace {

struct Gradient {
  cv::Mat x, y, magnitude;  // CV_32FC1
};

Gradient gradient_of(const cv::Mat& intensity) {
  Gradient gradient;
  // Scharr's weights preserve the direction to a fraction of a degree; those of one side sum to 16.
  cv::Scharr(intensity, gradient.x, CV_32F, 1, 0, 1.0 / 32.0);
  cv::Scharr(intensity, gradient.y, CV_32F, 0, 1, 1.0 / 32.0);
  cv::magnitude(gradient.x, gradient.y, gradient.magnitude);
  return gradient;
}

/// Typical gradient around each pixel: the squared mean of roots, so that a few large ones count little.
cv::Mat typical_magnitude(const cv::Mat& magnitude, double neighbourhood_px) {
  cv::Mat root, typical;
  cv::sqrt(magnitude, root);
  const int side = std::clamp(2 * static_cast<int>(neighbourhood_px / 2) + 1, 3, 255);
  cv::boxFilter(root, typical, CV_32F, {side, side}, {-1, -1}, true, cv::BORDER_REFLECT);
  return typical.mul(typical);
}

/// Of the eight directions to a neighbour, the one nearest to (gx, gy).
int step_towards(float gx, float gy, std::ptrdiff_t stride, float& length) {
  constexpr float kTangent = 0.41421356F;  // of 22.5 degrees
  const float ax = std::abs(gx), ay = std::abs(gy);
  const int sx = gx > 0 ? 1 : -1, sy = gy > 0 ? 1 : -1;
  const int row = static_cast<int>(stride);
  length = 1.0F;
  if (ay < kTangent * ax) return sx;
  if (ax < kTangent * ay) return sy * row;
  length = std::numbers::sqrt2_v<float>;
  return sy * row + sx;
}

}  // namespace

std::vector<EdgePoint> find_edge_points(const cv::Mat& intensity, const EdgeDetection& detection) {
  const Gradient gradient = gradient_of(intensity);
  const cv::Mat typical = typical_magnitude(gradient.magnitude, detection.neighbourhood_px);
  const auto prominence = static_cast<float>(detection.prominence);
  const auto floor = static_cast<float>(detection.floor);
  const auto stride = static_cast<std::ptrdiff_t>(gradient.magnitude.step1());

  std::vector<EdgePoint> edges;
  for (int y = 1; y + 1 < intensity.rows; ++y) {
    const auto* magnitude = gradient.magnitude.ptr<float>(y);
    const auto* around = typical.ptr<float>(y);
    const auto* gx = gradient.x.ptr<float>(y);
    const auto* gy = gradient.y.ptr<float>(y);
    for (int x = 1; x + 1 < intensity.cols; ++x) {
      const float here = magnitude[x];
      if (here <= prominence * around[x] + floor) continue;
      float length = 1.0F;
      const int step = step_towards(gx[x], gy[x], stride, length);
      const float ahead = magnitude[x + step], behind = magnitude[x - step];
      if (here < ahead || here <= behind) continue;
      const float offset = 0.5F * length * (behind - ahead) / (behind - 2 * here + ahead);
      const cv::Point2f normal(gx[x] / here, gy[x] / here);
      edges.push_back({cv::Point2f(static_cast<float>(x), static_cast<float>(y)) + offset * normal, normal});
    }
  }
  return edges;
}

namespace {

constexpr int kCell = 8;
/// Least cosine between an edge point's normal and the radius.
constexpr double kAligned = 0.94;  // cos 20 degrees

int cell_of(float at, int cells) { return std::clamp(static_cast<int>(at) / kCell, 0, cells - 1); }

/// Least squares for the change of centre and radius.
class CircleStep {
 public:
  /// With a weak prior, so that a short arc does not diverge: precisions, and the radius' distance from its
  /// prior.
  CircleStep(double centre_precision, double radius_precision, double radius_off) {
    normal_(0, 0) = normal_(1, 1) = centre_precision;
    normal_(2, 2) = radius_precision;
    right_(2) = -radius_precision * radius_off;
  }
  /// An edge point in the direction (ux, uy) from the centre, `beyond` the radius.
  void add(double ux, double uy, double beyond) {
    const cv::Vec3d row(ux, uy, 1.0);
    for (int i = 0; i < 3; ++i) {
      right_(i) += row(i) * beyond;
      for (int j = 0; j < 3; ++j) normal_(i, j) += row(i) * row(j);
    }
  }
  cv::Vec3d solve() const { return normal_.solve(right_, cv::DECOMP_CHOLESKY); }

 private:
  cv::Matx33d normal_ = cv::Matx33d::zeros();
  cv::Vec3d right_{0.0, 0.0, 0.0};
};

/// Fraction of the sectors that are in runs of at least three, with gaps of one closed.
double coverage_of(std::array<bool, kSectors> seen) {
  const auto at = [](std::size_t i) { return i % kSectors; };
  const auto before = seen;
  for (std::size_t i = 0; i < kSectors; ++i)
    if (!before[i]) seen[i] = before[at(i + 1)] && before[at(i + kSectors - 1)];
  std::size_t count = 0;
  for (std::size_t i = 0; i < kSectors; ++i) {
    const std::size_t far_left = at(i + kSectors - 2), left = at(i + kSectors - 1), right = at(i + 1);
    const bool in_run =
        (seen[left] && seen[right]) || (seen[left] && seen[far_left]) || (seen[right] && seen[at(i + 2)]);
    count += seen[i] && in_run ? 1 : 0;
  }
  return static_cast<double>(count) / kSectors;
}

}  // namespace

CircleSupport::CircleSupport(const std::vector<EdgePoint>& edges, cv::Size size)
    : columns_(std::max(1, (size.width + kCell - 1) / kCell)),
      rows_(std::max(1, (size.height + kCell - 1) / kCell)) {
  const auto cell = [&](const EdgePoint& edge) {
    return static_cast<std::size_t>(cell_of(edge.at.y, rows_) * columns_ + cell_of(edge.at.x, columns_));
  };
  first_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_) + 1, 0);
  for (const auto& edge : edges) ++first_[cell(edge) + 1];
  for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
  auto next = first_;
  edges_.resize(edges.size());
  for (const auto& edge : edges) edges_[next[cell(edge)]++] = edge;
  claimed_.assign(edges_.size(), 0);
}

/// Calls visit(index, ux, uy, beyond) for each unclaimed edge within `band` of the circle that points
/// inwards.
template <typename Visit>
void CircleSupport::visit_ring(const Circle& circle, double band, Visit visit) const {
  const double outer = circle.radius + band, inner = std::max(0.0, circle.radius - band);
  const auto [cx, cy] = std::pair(circle.centre.x, circle.centre.y);
  const int row_from = cell_of(static_cast<float>(cy - outer), rows_);
  const int row_to = cell_of(static_cast<float>(cy + outer), rows_);
  const int column_from = cell_of(static_cast<float>(cx - outer), columns_);
  const int column_to = cell_of(static_cast<float>(cx + outer), columns_);
  // Of a cell's middle to any point in it, and an edge's offset from its pixel.
  constexpr double kHalfDiagonal = 0.7072 * kCell + 1.0;
  const double outer2 = outer * outer, inner2 = inner * inner;
  const double farthest2 = (outer + kHalfDiagonal) * (outer + kHalfDiagonal);
  const double nearest = std::max(0.0, inner - kHalfDiagonal), nearest2 = nearest * nearest;
  for (int row = row_from; row <= row_to; ++row) {
    for (int column = column_from; column <= column_to; ++column) {
      const double x = (column + 0.5) * kCell - cx, y = (row + 0.5) * kCell - cy;
      const double far2 = x * x + y * y;
      if (far2 > farthest2 || far2 < nearest2) continue;
      const auto cell = static_cast<std::size_t>(row * columns_ + column);
      for (std::size_t i = first_[cell]; i < first_[cell + 1]; ++i) {
        if (claimed_[i] != 0) continue;
        const double dx = edges_[i].at.x - cx, dy = edges_[i].at.y - cy;
        const double square = dx * dx + dy * dy;
        if (square > outer2 || square < inner2) continue;
        const double inwards = -(dx * edges_[i].normal.x + dy * edges_[i].normal.y);
        if (!(inwards > 0.0) || inwards * inwards < kAligned * kAligned * square) continue;
        const double distance = std::sqrt(square);
        const double ux = dx / distance, uy = dy / distance;
        visit(i, ux, uy, distance - circle.radius);
      }
    }
  }
}

/// To either side of a circle, of the edge points by which it is fitted, step by step [px].
constexpr std::array kBands{4.0, 3.0, 2.0, 1.5, 1.5};
/// How far from a circle edge points may change its fit: a step leads no further than its band.
constexpr double kFitReach = kBands.front() + std::accumulate(kBands.begin(), kBands.end(), 0.0);

SupportedCircle CircleSupport::fit(const Circle& start, double radius_min, double radius_max) const {
  const double middle = 0.5 * (radius_min + radius_max), half = 0.5 * (radius_max - radius_min);
  Circle circle = start;
  for (const double band : kBands) {
    CircleStep step(0.1, 1.0 / (half * half + 1e-6), circle.radius - middle);
    visit_ring(circle, band,
               [&](std::size_t, double ux, double uy, double beyond) { step.add(ux, uy, beyond); });
    const cv::Vec3d change = step.solve();
    circle.centre += cv::Point2d(change(0), change(1));
    circle.radius = std::clamp(circle.radius + change(2), radius_min, radius_max);
  }
  std::array<bool, kSectors> seen{};
  visit_ring(circle, kBands.back(), [&](std::size_t, double ux, double uy, double) {
    const double turn = std::atan2(uy, ux) / (2 * std::numbers::pi) + 1.0;
    seen[static_cast<std::size_t>(turn * kSectors) % kSectors] = true;
  });
  return {circle, coverage_of(seen)};
}

void CircleSupport::claim(const Circle& circle) {
  constexpr double kReach = 2.0;
  std::vector<std::size_t> on;
  visit_ring(circle, kReach, [&](std::size_t i, double, double, double) { on.push_back(i); });
  for (const std::size_t i : on) claimed_[i] = 1;
}

void CircleSupport::release() { claimed_.assign(edges_.size(), 0); }

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
