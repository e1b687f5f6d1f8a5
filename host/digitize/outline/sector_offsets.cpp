#include "host/digitize/outline/sector_offsets.hpp"

#include <algorithm>
#include <cmath>

namespace strobe::digitize {

namespace {

constexpr double kTukey = 4.685;   // 95 % efficient on normal errors
constexpr double kMaxSd_px = 1.0;  // of a sector's offset

bool is_usable(const SectorEdge& edge) { return edge.usable && edge.sd_px < kMaxSd_px; }

/// The variance to add so that the median of residual²/variance is that of a squared normal variable. A median is above
/// a value where at least half of the numbers are: counting takes a tenth of the time of sorting.
double extra_variance(const std::vector<SectorEdge>& edges, std::span<const double> residual) {
  constexpr double kMedianOfSquare = 0.4549;
  std::vector<double> excess;  // variance that would put each ratio at the median
  for (std::size_t i = 0; i < edges.size(); ++i)
    if (is_usable(edges[i]))
      excess.push_back(residual[i] * residual[i] / kMedianOfSquare - edges[i].sd_px * edges[i].sd_px);
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

}  // namespace

void reweight(SectorOffsets& offsets, std::span<const double> residuals) {
  offsets.extra_variance = extra_variance(offsets.edges, residuals);
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    const SectorEdge& edge = offsets.edges[i];
    offsets.weight[i] = offsets.robust[i] = offsets.sensitivity[i] = 0.0;
    if (!is_usable(edge)) continue;
    const double variance = edge.sd_px * edge.sd_px + offsets.extra_variance;
    const double z2 = residuals[i] * residuals[i] / (variance * kTukey * kTukey);
    if (z2 >= 1.0) continue;
    offsets.robust[i] = (1.0 - z2) * (1.0 - z2);
    offsets.weight[i] = offsets.robust[i] / variance;
    offsets.sensitivity[i] = (1.0 - z2) * std::max(0.0, 1.0 - 5.0 * z2) / variance;
  }
}

void downweight_shadow(SectorOffsets& offsets, double sigma_px) {
  const int count = static_cast<int>(offsets.edges.size());
  constexpr int kReach = 4;
  const auto at = [&](int i) { return static_cast<std::size_t>((i + count) % count); };
  std::vector<bool> shadow(offsets.edges.size());
  for (int i = 0; i < count; ++i) {
    int without = 0, with = 0;
    for (int k = -kReach; k <= kReach; ++k) {
      const SectorEdge& edge = offsets.edges[at(i + k)];
      without += edge.no_edge ? 1 : 0;
      with += edge.usable ? 1 : 0;
    }
    shadow[at(i)] = without > with && without > kReach;
  }
  offsets.common_sd.assign(offsets.edges.size(), 0.0);
  for (int i = 0; i < count; ++i) {
    SectorEdge& edge = offsets.edges[at(i)];
    if (!edge.usable) continue;
    if (shadow[at(i)]) {
      edge.usable = false;
      continue;
    }
    bool near = false;
    for (int k = -kReach; k <= kReach; ++k) near = near || shadow[at(i + k)];
    if (!near) continue;
    const double common = sigma_px * std::min(1.0, edge.limb_ratio * edge.limb_ratio);
    offsets.common_sd[at(i)] = common;
    edge.sd_px = std::hypot(edge.sd_px, common);
  }
}

}  // namespace strobe::digitize
