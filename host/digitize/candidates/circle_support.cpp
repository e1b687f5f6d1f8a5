#include "host/digitize/candidates/circle_support.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace strobe::digitize {

namespace {

constexpr int kCell = 8;
/// Least cosine between an edge point's normal and the radius.
constexpr double kAligned = 0.94;  // cos 20 degrees
constexpr std::size_t kSectors = 72;

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

SupportedCircle CircleSupport::fit(const Circle& start, double radius_min, double radius_max) const {
  constexpr std::array kBands{4.0, 3.0, 2.0, 1.5, 1.5};
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
  constexpr double kBand = 2.0;
  std::vector<std::size_t> on;
  visit_ring(circle, kBand, [&](std::size_t i, double, double, double) { on.push_back(i); });
  for (const std::size_t i : on) claimed_[i] = 1;
}

void CircleSupport::release() { claimed_.assign(edges_.size(), 0); }

}  // namespace strobe::digitize
