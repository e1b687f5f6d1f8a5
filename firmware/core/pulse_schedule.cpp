#include "firmware/core/pulse_schedule.hpp"

#include <algorithm>
#include <cassert>

namespace strobe::firmware {

namespace {

constexpr Duration kLongest = kLongestOfPlan;

Duration impact_at(const ShotPlan& plan, const Rig& rig) {
  return plan.impact_at == Duration{} ? rig.plan.impact_at : plan.impact_at;
}

}  // namespace

PlanLimits plan_limits(const Rig& rig) {
  PlanLimits limits;
  limits.lamp_period = rig.lamps.min_period;
  limits.lamp_pulse = rig.lamps.pulse;
  limits.flash_interval = min_flash_interval(rig);
  limits.max_flashes = rig.lamps.max_flashes;
  limits.longest_exposure = rig.shutter.max_open;
  limits.gate_fitted = rig.line(Line::gate).fitted;
  limits.impact_at = rig.plan.impact_at;
  return limits;
}

Result<void> check_plan(const ShotPlan& plan, const Rig& rig) {
  const auto problem = plan_problem(plan, plan_limits(rig));
  return problem ? Result<void>(fail(problem->what)) : Result<void>{};
}

Duration min_flash_interval(const Rig& rig) { return rig.lamps.max_on + rig.tolerance.spin; }

namespace {

Duration shortest_interval(const ShotPlan& plan) noexcept {
  if (plan.code.size() < 2) return plan.period;
  Duration shortest = kLongest;
  for (std::size_t i = 1; i < plan.code.size(); ++i)
    shortest = std::min(shortest, plan.code[i].offset - plan.code[i - 1].offset);
  return shortest;
}

void add_train(const ShotPlan& plan, const Rig& rig, Duration first, std::int32_t flash_count,
               std::vector<PlannedPulse>& pulses) noexcept {
  for (std::int32_t k = 0; k < flash_count; ++k) {
    const CodedFlash flash =
        plan.code.empty() ? CodedFlash{plan.period * k, Lamps::both} : plan.code[static_cast<std::size_t>(k)];
    assert(pulses.size() < pulses.capacity());
    pulses.push_back({first + flash.offset, Output::strobes, rig.lamps.pulse, k, flash.lamps});
  }
}

}  // namespace

void build_schedule(const ShotPlan& plan, const Rig& rig, PulseSchedule& schedule) noexcept {
  schedule.pulses.clear();
  schedule.burst.clear();
  schedule.gated = plan.train == Train::gated;
  schedule.flash_count = flash_count(plan);
  // A coded train of one flash has none of its own.
  schedule.shortest_interval = std::max(shortest_interval(plan), min_flash_interval(rig));
  const Duration trigger_at = rig.shutter.lag + impact_at(plan, rig) - rig.machine.lag;
  const Duration shutter_at = plan.dry ? Duration{} : std::max(Duration{}, -trigger_at);
  schedule.exposure_begin = shutter_at + rig.shutter.lag;
  schedule.exposure_end = schedule.exposure_begin + plan.exposure;
  schedule.pulses.push_back({shutter_at, Output::shutter, plan.exposure, -1});
  if (!plan.dry) schedule.pulses.push_back({shutter_at + trigger_at, Output::trigger, rig.machine.pulse, -1});
  if (schedule.gated) {
    add_train(plan, rig, plan.gate_delay, schedule.flash_count, schedule.burst);
  } else {
    add_train(plan, rig, schedule.exposure_begin, schedule.flash_count, schedule.pulses);
  }
  std::sort(schedule.pulses.begin(), schedule.pulses.end(), [](const PlannedPulse& a, const PlannedPulse& b) {
    return a.at != b.at ? a.at < b.at : index_of(a.output) > index_of(b.output);  // the machine last
  });
  assert(schedule.pulses.front().at >= Duration{} && schedule.exposure_end > schedule.exposure_begin);
}

bool add_burst(const ShotPlan& plan, const Rig& rig, Duration first, PulseSchedule& schedule) noexcept {
  if (first + train_length(plan, schedule.flash_count) + rig.lamps.pulse > schedule.exposure_end)
    return false;
  add_train(plan, rig, first, schedule.flash_count, schedule.pulses);
  assert(schedule.pulses.back().at <= schedule.exposure_end);
  return true;
}

}  // namespace strobe::firmware
