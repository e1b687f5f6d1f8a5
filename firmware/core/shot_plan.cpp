#include "firmware/core/shot_plan.hpp"

#include <algorithm>
#include <array>

namespace strobe::firmware {

namespace {

constexpr Duration kLongest = milliseconds(3'600'000);  // keeps sums of a hostile request far from overflow

std::string us(Duration d) { return std::to_string(d / microseconds(1)) + " us"; }
std::string ms(Duration d) { return std::to_string(d / milliseconds(1)) + " ms"; }
bool sane(Duration d) { return d >= Duration{} && d <= kLongest; }

Duration impact_at(const PlanRequest& request, const Rig& rig) {
  return request.impact_at == Duration{} ? rig.plan.impact_at : request.impact_at;
}

/// From the train's first instant to its last flash.
Duration length_of(const PlanRequest& request, std::int32_t flashes) {
  return request.code.empty() ? request.period * (flashes - 1) : request.code.back().offset;
}

std::string flash_of_code(std::size_t i) { return "flash " + std::to_string(i) + " of the coded train "; }

Result<void> check_code(const CodedTrain& code, const Rig& rig) {
  std::array<Duration, 2> last{-kLongest, -kLongest};
  for (std::size_t i = 0; i < code.size(); ++i) {
    const CodedFlash flash = code[i];
    if (flash.lamps < Lamps::a || flash.lamps > Lamps::both) return fail(flash_of_code(i) + "names no lamp");
    if (!sane(flash.offset))
      return fail(flash_of_code(i) + "has an instant that is negative or absurdly large");
    if (i > 0 && flash.offset - code[i - 1].offset <= min_flash_interval(rig)) {
      return fail(flash_of_code(i) + "comes " + us(flash.offset - code[i - 1].offset) +
                  " after the one before, where more than " + us(min_flash_interval(rig)) + " are needed");
    }
    for (const std::size_t lamp : {0u, 1u}) {
      if (lamp == 0 ? !has_a(flash.lamps) : !has_b(flash.lamps)) continue;
      if (flash.offset - last[lamp] < rig.lamps.min_period) {
        return fail(flash_of_code(i) + "comes " + us(flash.offset - last[lamp]) + " after lamp " +
                    (lamp == 0 ? "A" : "B") + "'s one before, shorter than the lamps' " +
                    us(rig.lamps.min_period));
      }
      last[lamp] = flash.offset;
    }
  }
  return {};
}

Result<void> check_interval(const PlanRequest& request, const Rig& rig) {
  if (!request.code.empty()) return check_code(request.code, rig);
  if (request.period < rig.lamps.min_period) {
    return fail("a period of " + us(request.period) + " is shorter than the lamps' " +
                us(rig.lamps.min_period));
  }
  return {};
}

Result<void> check_gated(const PlanRequest& request, const Rig& rig) {
  if (!rig.line(Line::gate).fitted)
    return fail("a gated train needs a gate, and lines.gate is not in the rig file");
  if (request.flash_count < 1) return fail("a gated train needs a flash_count of at least 1");
  if (!request.code.empty() && request.flash_count != static_cast<std::int32_t>(request.code.size()))
    return fail("a flash_count of " + std::to_string(request.flash_count) +
                " is not that of the coded train");
  const Duration burst = request.gate_delay + length_of(request, request.flash_count) + rig.lamps.pulse;
  if (burst > request.exposure) {
    return fail("gate delay and burst take " + us(burst) + ", longer than the exposure of " +
                us(request.exposure));
  }
  return {};
}

Result<void> check_free(const PlanRequest& request) {
  if (request.flash_count != 0) return fail("a free train has a flash_count of 0: the exposure decides");
  if (request.gate_delay != Duration{}) return fail("a free train has no gate delay");
  if (!request.code.empty() && request.code.back().offset >= request.exposure)
    return fail("the coded train takes " + us(request.code.back().offset) + ", longer than the exposure of " +
                us(request.exposure));
  return {};
}

}  // namespace

Result<void> check_plan(const PlanRequest& request, const Rig& rig) {
  if (request.train != Train::free && request.train != Train::gated) return fail("unknown kind of train");
  if (!sane(request.period) || !sane(request.exposure) || !sane(request.gate_delay) ||
      !sane(request.impact_at) || request.flash_count < 0 || request.flash_count > kMaxFlashes) {
    return fail("a number of the plan is negative or absurdly large");
  }
  if (auto interval = check_interval(request, rig); !interval) return interval;
  if (request.exposure == Duration{}) return fail("the exposure must be longer than 0");
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

Duration min_flash_interval(const Rig& rig) { return rig.lamps.max_on + rig.tolerance.spin; }

std::int32_t flash_count(const PlanRequest& request) {
  if (!request.code.empty()) return static_cast<std::int32_t>(request.code.size());
  if (request.train == Train::gated) return request.flash_count;
  const std::int64_t count = (request.exposure + request.period - Duration{1}) / request.period;
  return static_cast<std::int32_t>(std::min<std::int64_t>(count, std::int64_t{kMaxFlashes} + 1));
}

namespace {

Duration shortest_interval(const PlanRequest& request) noexcept {
  if (request.code.size() < 2) return request.period;
  Duration shortest = kLongest;
  for (std::size_t i = 1; i < request.code.size(); ++i)
    shortest = std::min(shortest, request.code[i].offset - request.code[i - 1].offset);
  return shortest;
}

void add_train(const PlanRequest& request, const Rig& rig, Duration first, ShotPlan& plan) noexcept {
  for (std::int32_t k = 0; k < plan.flash_count; ++k) {
    const CodedFlash flash = request.code.empty() ? CodedFlash{request.period * k, Lamps::both}
                                                  : request.code[static_cast<std::size_t>(k)];
    plan.pulses.push_back({first + flash.offset, Output::strobes, rig.lamps.pulse, k, flash.lamps});
  }
}

}  // namespace

void build_plan(const PlanRequest& request, const Rig& rig, ShotPlan& plan) noexcept {
  plan.pulses.clear();
  plan.gated = request.train == Train::gated;
  plan.flash_count = flash_count(request);
  // A coded train of one flash has none of its own.
  plan.shortest_interval = std::max(shortest_interval(request), min_flash_interval(rig));
  const Duration trigger_at = rig.shutter.lag + impact_at(request, rig) - rig.machine.lag;
  const Duration shutter_at = request.dry ? Duration{} : std::max(Duration{}, -trigger_at);
  plan.exposure_begin = shutter_at + rig.shutter.lag;
  plan.exposure_end = plan.exposure_begin + request.exposure;
  plan.pulses.push_back({shutter_at, Output::shutter, request.exposure, -1});
  if (!request.dry) plan.pulses.push_back({shutter_at + trigger_at, Output::trigger, rig.machine.pulse, -1});
  if (!plan.gated) add_train(request, rig, plan.exposure_begin, plan);
  std::sort(plan.pulses.begin(), plan.pulses.end(), [](const PlannedPulse& a, const PlannedPulse& b) {
    return a.at != b.at ? a.at < b.at : index_of(a.output) > index_of(b.output);  // the machine last
  });
}

bool add_burst(const PlanRequest& request, const Rig& rig, Duration first, ShotPlan& plan) noexcept {
  if (first + length_of(request, plan.flash_count) + rig.lamps.pulse > plan.exposure_end) return false;
  add_train(request, rig, first, plan);
  return true;
}

}  // namespace strobe::firmware
