#include "host/design/needs.hpp"

#include "host/series/sample_size.hpp"

namespace strobe::host {
std::vector<Need> needs(const Prediction& prediction, std::span<const Wanted> wanted,
                        std::span<const Wanted> differences, double power) {
  std::vector<Need> list;
  const auto add = [&](const Wanted& w, bool is_difference) {
    const auto& q = prediction.of(w.quantity);
    if (!q) return;
    Need need{w.quantity, w.size(q->mean), is_difference, std::nullopt};
    const Scatter scatter{.sd = q->scatter_sd()};
    // Both series are fired with one rig, ball and calibration: what they share cancels.
    const auto count =
        is_difference ? shots_for_difference({.first = scatter, .second = scatter}, need.half_width, power)
                      : shots_for_mean(scatter, q->shared_sd, need.half_width);
    if (count) need.shots = count->shots;
    list.push_back(need);
  };
  for (const Wanted& w : wanted) add(w, false);
  for (const Wanted& w : differences) add(w, true);
  return list;
}

}  // namespace strobe::host
