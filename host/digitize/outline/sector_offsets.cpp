#include "host/digitize/outline/sector_offsets.hpp"

#include <algorithm>
#include <cmath>

#include "host/digitize/core/statistics.hpp"

namespace strobe::digitize {

namespace {

constexpr double kMaxSd_px = 1.0;  // of a sector's offset

bool is_usable(const SectorEdge& edge) { return edge.usable && edge.sd_px < kMaxSd_px; }

double variance_of(const SectorOffsets& offsets, std::size_t i) {
  return offsets.edges[i].sd_px * offsets.edges[i].sd_px + offsets.common_sd[i] * offsets.common_sd[i];
}

/// The variance to add so that the median of residual²/variance is that of a squared normal variable. A
/// median is above a value where at least half of the numbers are: counting takes a tenth of the time of
/// sorting.
double extra_variance(const SectorOffsets& offsets, std::span<const double> residual) {
  const std::vector<SectorEdge>& edges = offsets.edges;
  constexpr double kMedianOfSquare = 0.4549;
  std::vector<double> excess;  // variance that would put each ratio at the median
  for (std::size_t i = 0; i < edges.size(); ++i)
    if (is_usable(edges[i]))
      excess.push_back(residual[i] * residual[i] / kMedianOfSquare - variance_of(offsets, i));
  const auto half = static_cast<std::ptrdiff_t>(excess.size() - excess.size() / 2);
  const auto is_too_small = [&](double extra) {
    std::ptrdiff_t above = 0;
    for (const double e : excess) above += e > extra ? 1 : 0;
    return !excess.empty() && above >= half;
  };
  double low = 1e-6, high = 4.0;
  if (!is_too_small(low)) return low;
  for (int i = 0; i < 14; ++i) {
    const double middle = std::sqrt(low * high);
    (is_too_small(middle) ? low : high) = middle;
  }
  return high;
}

constexpr int kReach = 4;  // sectors to either side that tell together

// A limb whose step is that many times what its curvature adds over a blur's width hides no more of the law
// by which light falls than an eighth of the blur, as much as texture does.
constexpr double kClearRatio = 1.0 / 8.0;

std::size_t around(int i, int count) { return static_cast<std::size_t>((i + 2 * count) % count); }

/// Rise by the limb's curvature over a blur's width, over the step at the limb, both of the sectors around.
double limb_ratio(const std::vector<SectorEdge>& edges, int i) {
  double step = 0.0, rounding = 0.0;
  for (int k = -kReach; k <= kReach; ++k) {
    const SectorEdge& edge = edges[around(i + k, static_cast<int>(edges.size()))];
    step += edge.step;
    rounding += std::max(0.0, edge.rounding);
  }
  return rounding / std::max(step, 1e-3 * rounding + 1e-12);
}

std::vector<bool> shadow_of(const std::vector<SectorEdge>& edges) {
  const int count = static_cast<int>(edges.size());
  std::vector<bool> shadow(edges.size());
  for (int i = 0; i < count; ++i) {
    int without = 0, with = 0;
    for (int k = -kReach; k <= kReach; ++k) {
      const SectorEdge& edge = edges[around(i + k, count)];
      without += edge.no_edge ? 1 : 0;
      with += edge.usable ? 1 : 0;
    }
    shadow[around(i, count)] = without > with && without > kReach;
  }
  return shadow;
}

}  // namespace

void reweight(SectorOffsets& offsets, std::span<const double> residuals) {
  offsets.extra_variance = extra_variance(offsets, residuals);
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    const SectorEdge& edge = offsets.edges[i];
    offsets.weight[i] = offsets.robust[i] = offsets.sensitivity[i] = 0.0;
    if (!is_usable(edge)) continue;
    const double variance = variance_of(offsets, i) + offsets.extra_variance;
    const double z2 = residuals[i] * residuals[i] / (variance * kBiweightReach_sd * kBiweightReach_sd);
    if (z2 >= 1.0) continue;
    offsets.robust[i] = (1.0 - z2) * (1.0 - z2);
    offsets.weight[i] = offsets.robust[i] / variance;
    offsets.sensitivity[i] = (1.0 - z2) * std::max(0.0, 1.0 - 5.0 * z2) / variance;
  }
}

void downweight_shadow(SectorOffsets& offsets, double sigma_px) {
  // With an eighth, sds were four times too large where a dark side only fades.
  constexpr int kHalfLit = 5;
  const int count = static_cast<int>(offsets.edges.size());
  offsets.half_lit = kHalfLit * std::ranges::count(offsets.edges, true, &SectorEdge::no_edge) >= count;
  const std::vector<bool> shadow = shadow_of(offsets.edges);
  offsets.common_sd.assign(offsets.edges.size(), 0.0);
  for (int i = 0; i < count; ++i) {
    if (!shadow[around(i, count)]) continue;
    for (const int way : {-1, 1}) {
      for (int k = way; std::abs(k) < count && !shadow[around(i + k, count)]; k += way) {
        const double ratio = limb_ratio(offsets.edges, i + k);
        if (std::abs(k) > kReach && (!offsets.half_lit || ratio < kClearRatio)) break;
        double& common = offsets.common_sd[around(i + k, count)];
        common = std::max(common, sigma_px * std::min(1.0, offsets.half_lit ? ratio : ratio * ratio));
      }
    }
  }
  for (int i = 0; i < count; ++i) {
    SectorEdge& edge = offsets.edges[around(i, count)];
    if (shadow[around(i, count)]) edge.usable = false;
  }
}

}  // namespace strobe::digitize
