#include "host/digitize/surface/edge_profile_samples.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace strobe::digitize {

std::optional<EdgeSamples> samples_across(const Photograph& photograph, const OcclusionMask& occluded,
                                          int column, double row, int along) {
  constexpr int kReach = kProfileHalfReach_px;
  if (!(row > 0.0 && row < photograph.height())) return std::nullopt;
  EdgeSamples samples;
  samples.top = static_cast<int>(std::lround(row)) - kReach;
  if (samples.top < 0 || samples.top + 2 * kReach >= photograph.height()) return std::nullopt;
  if (column < along / 2 || column + along / 2 >= photograph.width()) return std::nullopt;
  for (int k = 0; k <= 2 * kReach; k += kReach / 2) {
    for (const int side : {-along / 2, along / 2})
      if (occluded.at(column + side, samples.top + k)) return std::nullopt;
  }
  const double full = kSaturatedShare * static_cast<double>(photograph.saturation);
  for (int k = 0; k <= 2 * kReach; ++k) {
    const float* values = photograph.intensity.ptr<float>(samples.top + k) + column - along / 2;
    double& mean = samples.intensity[static_cast<std::size_t>(k)];
    mean = std::accumulate(values, values + along, 0.0) / along;
    if (*std::max_element(values, values + along) >= full) mean = std::max(mean, full);
  }
  return samples;
}

}  // namespace strobe::digitize
