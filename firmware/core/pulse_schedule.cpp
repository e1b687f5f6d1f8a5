#include "firmware/core/pulse_schedule.hpp"

#include <algorithm>
#include <array>
#include <cassert>

namespace strobe::firmware {

namespace {

constexpr Duration kLongest = milliseconds(3'600'000);  // keeps sums of a hostile plan far from overflow

std::string us(Duration d) { return std::to_string(d / microseconds(1)) + " us"; }
std::string ms(Duration d) { return std::to_string(d / milliseconds(1)) + " ms"; }
bool sane(Duration d) { return d >= Duration{} && d <= kLongest; }

Duration impact_at(const ShotPlan& plan, const Rig& rig) {
  return plan.impact_at == Duration{} ? rig.plan.impact_at : plan.impact_at;
}

/// From the train's first instant to its last flash.
Duration length_of(const ShotPlan& plan, std::int32_t flashes) {
  return plan.code.empty() ? plan.period * (flashes - 1) : plan.code.back().offset;
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

Result<void> check_interval(const ShotPlan& plan, const Rig& rig) {
  if (!plan.code.empty()) return check_code(plan.code, rig);
  if (plan.period < rig.lamps.min_period) {
    return fail("a period of " + us(plan.period) + " is shorter than the lamps' " + us(rig.lamps.min_period));
  }
  return {};
}

Result<void> check_gated(const ShotPlan& plan, const Rig& rig) {
  if (!rig.line(Line::gate).fitted)
    return fail("a gated train needs a gate, and lines.gate is not in the rig file");
  if (plan.flash_count < 1) return fail("a gated train needs a flash_count of at least 1");
  if (!plan.code.empty() && plan.flash_count != static_cast<std::int32_t>(plan.code.size()))
    return fail("a flash_count of " + std::to_string(plan.flash_count) + " is not that of the coded train");
  const Duration burst = plan.gate_delay + length_of(plan, plan.flash_count) + rig.lamps.pulse;
  if (burst > plan.exposure) {
    return fail("gate delay and burst take " + us(burst) + ", longer than the exposure of " +
                us(plan.exposure));
  }
  return {};
}

Result<void> check_free(const ShotPlan& plan) {
  if (plan.flash_count != 0) return fail("a free train has a flash_count of 0: the exposure decides");
  if (plan.gate_delay != Duration{}) return fail("a free train has no gate delay");
  if (!plan.code.empty() && plan.code.back().offset >= plan.exposure)
    return fail("the coded train takes " + us(plan.code.back().offset) + ", longer than the exposure of " +
                us(plan.exposure));
  return {};
}

}  // namespace

Result<void> check_plan(const ShotPlan& plan, const Rig& rig) {
  if (plan.train != Train::free && plan.train != Train::gated) return fail("unknown kind of train");
  if (!sane(plan.period) || !sane(plan.exposure) || !sane(plan.gate_delay) || !sane(plan.impact_at) ||
      plan.flash_count < 0 || plan.flash_count > kMaxFlashes) {
    return fail("a number of the plan is negative or absurdly large");
  }
  if (auto interval = check_interval(plan, rig); !interval) return interval;
  if (plan.exposure == Duration{}) return fail("the exposure must be longer than 0");
  if (plan.exposure > rig.shutter.max_open) {
    return fail("an exposure of " + ms(plan.exposure) + " is longer than the shutter's " +
                ms(rig.shutter.max_open));
  }
  auto checked = plan.train == Train::gated ? check_gated(plan, rig) : check_free(plan);
  if (!checked) return checked;
  if (impact_at(plan, rig) >= plan.exposure) {
    return fail("the ball would meet the plate " + ms(impact_at(plan, rig)) +
                " after the shutter opened, but the exposure ends after " + ms(plan.exposure));
  }
  if (flash_count(plan) > rig.lamps.max_flashes) {
    return fail(std::to_string(flash_count(plan)) + " flashes are more than the " +
                std::to_string(rig.lamps.max_flashes) + " a shot may have");
  }
  return {};
}

Duration min_flash_interval(const Rig& rig) { return rig.lamps.max_on + rig.tolerance.spin; }

std::int32_t flash_count(const ShotPlan& plan) {
  if (!plan.code.empty()) return static_cast<std::int32_t>(plan.code.size());
  if (plan.train == Train::gated) return plan.flash_count;
  const std::int64_t count = (plan.exposure + plan.period - Duration{1}) / plan.period;
  return static_cast<std::int32_t>(std::min<std::int64_t>(count, std::int64_t{kMaxFlashes} + 1));
}

namespace {

Duration shortest_interval(const ShotPlan& plan) noexcept {
  if (plan.code.size() < 2) return plan.period;
  Duration shortest = kLongest;
  for (std::size_t i = 1; i < plan.code.size(); ++i)
    shortest = std::min(shortest, plan.code[i].offset - plan.code[i - 1].offset);
  return shortest;
}

void add_train(const ShotPlan& plan, const Rig& rig, Duration first, PulseSchedule& schedule) noexcept {
  for (std::int32_t k = 0; k < schedule.flash_count; ++k) {
    const CodedFlash flash =
        plan.code.empty() ? CodedFlash{plan.period * k, Lamps::both} : plan.code[static_cast<std::size_t>(k)];
    assert(schedule.pulses.size() < schedule.pulses.capacity());
    schedule.pulses.push_back({first + flash.offset, Output::strobes, rig.lamps.pulse, k, flash.lamps});
  }
}

}  // namespace

void build_schedule(const ShotPlan& plan, const Rig& rig, PulseSchedule& schedule) noexcept {
  schedule.pulses.clear();
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
  if (!schedule.gated) add_train(plan, rig, schedule.exposure_begin, schedule);
  std::sort(schedule.pulses.begin(), schedule.pulses.end(), [](const PlannedPulse& a, const PlannedPulse& b) {
    return a.at != b.at ? a.at < b.at : index_of(a.output) > index_of(b.output);  // the machine last
  });
}

bool add_burst(const ShotPlan& plan, const Rig& rig, Duration first, PulseSchedule& schedule) noexcept {
  if (first + length_of(plan, schedule.flash_count) + rig.lamps.pulse > schedule.exposure_end) return false;
  add_train(plan, rig, first, schedule);
  return true;
}

}  // namespace strobe::firmware
