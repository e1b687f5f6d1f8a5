#include "firmware/core/tick.hpp"

#include <algorithm>
#include <cassert>
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

namespace {

/// One flash within the tick weighs more than all of a shot that are near it.
constexpr std::int64_t kHit = 100'000'000;
constexpr std::int64_t kNear = 10'000;
/// The tick begins early or late by this, and now and then takes twice as long.
constexpr Duration kMargin = microseconds(10);

}  // namespace

TickAvoidance::TickAvoidance(const Tick& tick) noexcept : tick_(tick) {
  if (!tick_.known()) return;
  const Duration step = std::max(Duration{1}, tick_.period / static_cast<std::int64_t>(kSteps));
  const auto steps = static_cast<std::int64_t>(kSteps);
  const std::int64_t after = std::min(steps, (2 * tick_.length + kMargin) / step);
  const std::int64_t before = std::min(steps, 1 + kMargin / step);
  for (std::int64_t k = 0; k < steps; ++k) {
    const std::int64_t distance = std::min(k - after, steps - before - k);
    cost_[static_cast<std::size_t>(k)] = distance <= 0 ? kHit : kNear / distance;
  }
}

std::size_t TickAvoidance::step_of(Duration after_tick) const noexcept {
  const Duration phase = (after_tick % tick_.period + tick_.period) % tick_.period;
  return static_cast<std::size_t>(phase * static_cast<std::int64_t>(kSteps) / tick_.period) % kSteps;
}

Duration TickAvoidance::delay(MonoTime earliest, const PulseSchedule& schedule) const noexcept {
  if (!tick_.known()) return {};
  std::array<std::int64_t, kSteps> flashes{};
  for (const PlannedPulse& pulse : schedule.pulses) {
    if (pulse.output == Output::strobes) ++flashes[step_of(earliest + pulse.at - MonoTime{tick_.phase})];
  }
  assert(tick_.phase >= Duration{} && tick_.phase < tick_.period);
  std::size_t best = 0;
  std::int64_t least = 0;
  for (std::size_t shift = 0; shift < kSteps; ++shift) {
    std::int64_t cost = 0;
    for (std::size_t k = 0; k < kSteps; ++k) cost += flashes[k] * cost_[(k + shift) % kSteps];
    if (shift == 0 || cost < least) {
      best = shift;
      least = cost;
    }
  }
  return tick_.period * static_cast<std::int64_t>(best) / static_cast<std::int64_t>(kSteps);
}

}  // namespace strobe::firmware
