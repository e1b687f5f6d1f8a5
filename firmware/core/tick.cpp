#include "firmware/core/tick.hpp"

#include <algorithm>
#include <set>
#include <vector>

namespace strobe::firmware {

namespace {

constexpr Duration kWidth = microseconds(40);

std::vector<Gap> at_phase(std::span<const Gap> gaps, std::int64_t phase_ns, Duration period) {
  std::vector<Gap> group;
  for (const Gap& gap : gaps) {
    const std::int64_t after_ns =
        (to_ns(gap.at) % period.count() - phase_ns + period.count()) % period.count();
    if (after_ns <= kWidth.count()) group.push_back(gap);
  }
  return group;
}

std::size_t periods_hit(const std::vector<Gap>& group, Duration period, std::int64_t phase_ns) {
  std::set<std::int64_t> hit;
  for (const Gap& gap : group) hit.insert((to_ns(gap.at) - phase_ns) / period.count());
  return hit.size();
}

}  // namespace

Tick detect_tick(std::span<const Gap> gaps, Duration period, int periods) {
  std::vector<Gap> best;
  std::size_t most = 0;
  std::int64_t phase_ns = 0;
  for (const Gap& gap : gaps) {
    const std::int64_t candidate_ns = to_ns(gap.at) % period.count();
    std::vector<Gap> group = at_phase(gaps, candidate_ns, period);
    const std::size_t hit = periods_hit(group, period, candidate_ns);
    if (hit <= most) continue;
    most = hit;
    best = std::move(group);
    phase_ns = candidate_ns;
  }
  if (periods <= 0 || most * 5 < static_cast<std::size_t>(periods) * 3) return {};
  std::sort(best.begin(), best.end(), [](const Gap& a, const Gap& b) { return a.length < b.length; });
  return {period, nanoseconds(phase_ns), best[best.size() * 9 / 10].length};
}

}  // namespace strobe::firmware
