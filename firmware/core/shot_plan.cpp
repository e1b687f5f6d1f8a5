#include "firmware/core/shot_plan.hpp"

#include <algorithm>

namespace strobe::firmware {

namespace {

constexpr Duration kLongest = milliseconds(3'600'000);  // keeps sums of a hostile request far from overflow

std::string us(Duration d) { return std::to_string(d.ns / 1000) + " us"; }
std::string ms(Duration d) { return std::to_string(d.ns / 1'000'000) + " ms"; }
bool sane(Duration d) { return d >= Duration{0} && d <= kLongest; }

Duration impact_at(const PlanRequest& request, const Rig& rig) {
  return request.impact_at.ns == 0 ? rig.plan.impact_at : request.impact_at;
}

Result<void> check_gated(const PlanRequest& request, const Rig& rig) {
  if (!rig.line(Line::gate).fitted)
    return fail("a gated train needs a gate, and lines.gate is not in the rig file");
  if (request.flash_count < 1) return fail("a gated train needs a flash_count of at least 1");
  const Duration burst = request.gate_delay + request.period * (request.flash_count - 1) + rig.lamps.pulse;
  if (burst > request.exposure) {
    return fail("gate delay and burst take " + us(burst) + ", longer than the exposure of " +
                us(request.exposure));
  }
  return {};
}

Result<void> check_free(const PlanRequest& request) {
  if (request.flash_count != 0) return fail("a free train has a flash_count of 0: the exposure decides");
  if (request.gate_delay.ns != 0) return fail("a free train has no gate delay");
  return {};
}

}  // namespace

Result<void> check_plan(const PlanRequest& request, const Rig& rig) {
  if (request.train != Train::free && request.train != Train::gated) return fail("unknown kind of train");
  if (!sane(request.period) || !sane(request.exposure) || !sane(request.gate_delay) ||
      !sane(request.impact_at) || request.flash_count < 0 || request.flash_count > kMostFlashes) {
    return fail("a number of the plan is negative or absurdly large");
  }
  if (request.period < rig.lamps.min_period) {
    return fail("a period of " + us(request.period) + " is shorter than the lamps' " +
                us(rig.lamps.min_period));
  }
  if (request.exposure.ns == 0) return fail("the exposure must be longer than 0");
  if (request.exposure > rig.shutter.max_open) {
    return fail("an exposure of " + ms(request.exposure) + " is longer than the shutter's " +
                ms(rig.shutter.max_open));
  }
  auto checked = request.train == Train::gated ? check_gated(request, rig) : check_free(request);
  if (!checked) return checked;
  if (impact_at(request, rig) >= request.exposure) {
    return fail("the ball would meet the plate " + ms(impact_at(request, rig)) +
                " after the shutter opened, but the exposure ends after " + ms(request.exposure));
  }
  if (flash_count(request) > rig.lamps.max_flashes) {
    return fail(std::to_string(flash_count(request)) + " flashes are more than the " +
                std::to_string(rig.lamps.max_flashes) + " a shot may have");
  }
  return {};
}

std::int32_t flash_count(const PlanRequest& request) {
  if (request.train == Train::gated) return request.flash_count;
  const std::int64_t count = (request.exposure.ns + request.period.ns - 1) / request.period.ns;
  return static_cast<std::int32_t>(std::min<std::int64_t>(count, std::int64_t{kMostFlashes} + 1));
}

void build_plan(const PlanRequest& request, const Rig& rig, ShotPlan& plan) noexcept {
  plan.pulses.clear();
  plan.gated = request.train == Train::gated;
  plan.flash_count = flash_count(request);
  const Duration trigger_at = rig.shutter.lag + impact_at(request, rig) - rig.machine.lag;
  const Duration shutter_at = request.dry ? Duration{0} : std::max(Duration{0}, -trigger_at);
  plan.exposure_begin = shutter_at + rig.shutter.lag;
  plan.exposure_end = plan.exposure_begin + request.exposure;
  plan.pulses.push_back({shutter_at, Output::shutter, request.exposure, -1});
  if (!request.dry) plan.pulses.push_back({shutter_at + trigger_at, Output::trigger, rig.machine.pulse, -1});
  if (!plan.gated) {
    for (std::int32_t k = 0; k < plan.flash_count; ++k) {
      plan.pulses.push_back({plan.exposure_begin + request.period * k, Output::strobes, rig.lamps.pulse, k});
    }
  }
  std::sort(plan.pulses.begin(), plan.pulses.end(), [](const PlannedPulse& a, const PlannedPulse& b) {
    return a.at != b.at ? a.at < b.at : index_of(a.output) > index_of(b.output);  // the machine last
  });
}

bool add_burst(const PlanRequest& request, const Rig& rig, Duration first, ShotPlan& plan) noexcept {
  if (first + request.period * (plan.flash_count - 1) + rig.lamps.pulse > plan.exposure_end) return false;
  for (std::int32_t k = 0; k < plan.flash_count; ++k) {
    plan.pulses.push_back({first + request.period * k, Output::strobes, rig.lamps.pulse, k});
  }
  return true;
}

}  // namespace strobe::firmware
