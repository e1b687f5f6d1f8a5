#include "host/digitize/surface/edge_profile_samples.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace strobe::digitize {

int profile_count(const Photograph& photograph) {
  return std::min(kMaxProfiles, std::max(16, photograph.width() / kProfileColumns));
}

int profile_column(const Photograph& photograph, int profile) {
  return static_cast<int>((profile + 0.5) * photograph.width() / profile_count(photograph));
}

std::optional<EdgeSamples> samples_across(const Photograph& photograph, const OcclusionMask& occluded,
                                          int column, double row) {
  constexpr int kReach = kProfileHalfReach_px, kHalf = kProfileColumns / 2;
  if (!(row > 0.0 && row < photograph.height())) return std::nullopt;
  EdgeSamples samples;
  samples.top = static_cast<int>(std::lround(row)) - kReach;
  if (samples.top < 0 || samples.top + 2 * kReach >= photograph.height()) return std::nullopt;
  if (column < kHalf || column + kHalf >= photograph.width()) return std::nullopt;
  for (int k = 0; k <= 2 * kReach; k += kReach / 2) {
    for (const int side : {-kHalf, kHalf})
      if (occluded.at(column + side, samples.top + k)) return std::nullopt;
  }
  const double full = kSaturatedShare * static_cast<double>(photograph.saturation);
  for (int k = 0; k <= 2 * kReach; ++k) {
    const float* values = photograph.intensity.ptr<float>(samples.top + k) + column - kHalf;
    double& mean = samples.intensity[static_cast<std::size_t>(k)];
    mean = std::accumulate(values, values + kProfileColumns, 0.0) / kProfileColumns;
    if (*std::max_element(values, values + kProfileColumns) >= full) mean = std::max(mean, full);
  }
  return samples;
}

}  // namespace strobe::digitize
