#include "common/shot/plan_check.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <utility>

namespace strobe {

namespace {

using Problem = std::optional<PlanProblem>;

std::string us(Duration d) { return std::to_string(d / microseconds(1)) + " us"; }
std::string ms(Duration d) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%.13g ms", 1e-6 * static_cast<double>(d / nanoseconds(1)));
  return text.data();
}
bool sane(Duration d) { return d >= Duration{} && d <= kLongestOfPlan; }

Duration impact_at(const ShotPlan& plan, const PlanLimits& limits) {
  return plan.impact_at == Duration{} ? limits.impact_at : plan.impact_at;
}

Problem in_code(std::size_t i, const std::string& what) {
  return PlanProblem{"intervals_us", "flash " + std::to_string(i) + " of the coded train " + what};
}

Problem check_code(const CodedTrain& code, const PlanLimits& limits) {
  std::array<Duration, 2> last{-kLongestOfPlan, -kLongestOfPlan};
  for (std::size_t i = 0; i < code.size(); ++i) {
    const CodedFlash flash = code[i];
    if (flash.lamps < Lamps::a || flash.lamps > Lamps::both) return in_code(i, "names no lamp");
    if (!sane(flash.offset)) return in_code(i, "is not from 0 to 1 h after the first");
    if (i > 0 && flash.offset - code[i - 1].offset <= limits.flash_interval) {
      return in_code(i, "comes " + us(flash.offset - code[i - 1].offset) +
                            " after the one before, where more than " + us(limits.flash_interval) +
                            " are needed");
    }
    for (const std::size_t lamp : {0u, 1u}) {
      if (lamp == 0 ? !has_a(flash.lamps) : !has_b(flash.lamps)) continue;
      if (flash.offset - last[lamp] < limits.lamp_period) {
        return in_code(i, "comes " + us(flash.offset - last[lamp]) + " after lamp " +
                              (lamp == 0 ? "A" : "B") + "'s one before, shorter than the lamps' " +
                              us(limits.lamp_period));
      }
      last[lamp] = flash.offset;
    }
  }
  return std::nullopt;
}

Problem check_ranges(const ShotPlan& plan) {
  const std::array durations{std::pair{"period_us", plan.period}, std::pair{"shutter_open_ms", plan.exposure},
                             std::pair{"gate_delay_ms", plan.gate_delay},
                             std::pair{"impact_at_ms", plan.impact_at}};
  for (const auto& [field, duration] : durations)
    if (!sane(duration)) return PlanProblem{field, std::string(field) + " is not from 0 to 1 h"};
  if (plan.flash_count >= 0 && plan.flash_count <= kMaxFlashes) return std::nullopt;
  return PlanProblem{"flash_count", "flash_count is not from 0 to " + std::to_string(kMaxFlashes)};
}

Problem check_interval(const ShotPlan& plan, const PlanLimits& limits) {
  if (!plan.code.empty()) return check_code(plan.code, limits);
  if (plan.period < limits.lamp_period) {
    return PlanProblem{"period_us", "a period of " + us(plan.period) + " is shorter than the lamps' " +
                                        us(limits.lamp_period)};
  }
  return std::nullopt;
}

Problem check_gated(const ShotPlan& plan, const PlanLimits& limits) {
  if (!limits.gate_fitted)
    return PlanProblem{"train", "a gated train needs a gate, and lines.gate is not in the rig file"};
  if (plan.flash_count < 1)
    return PlanProblem{"flash_count", "a gated train needs a flash_count of at least 1"};
  if (!plan.code.empty() && plan.flash_count != static_cast<std::int32_t>(plan.code.size()))
    return PlanProblem{"flash_count", "a flash_count of " + std::to_string(plan.flash_count) +
                                          " is not that of the coded train"};
  const Duration burst = plan.gate_delay + train_length(plan, plan.flash_count) + limits.lamp_pulse;
  if (burst <= plan.exposure) return std::nullopt;
  return PlanProblem{"gate_delay_ms", "gate delay and burst take " + ms(burst) +
                                          ", longer than the exposure of " + ms(plan.exposure)};
}

Problem check_free(const ShotPlan& plan) {
  if (plan.flash_count != 0)
    return PlanProblem{"flash_count", "a free train has a flash_count of 0: the exposure decides"};
  if (plan.gate_delay != Duration{}) return PlanProblem{"gate_delay_ms", "a free train has no gate delay"};
  if (plan.code.empty() || plan.code.back().offset < plan.exposure) return std::nullopt;
  return PlanProblem{"intervals_us", "the coded train takes " + ms(plan.code.back().offset) +
                                         ", longer than the exposure of " + ms(plan.exposure)};
}

Problem check_exposure(const ShotPlan& plan, const PlanLimits& limits) {
  if (plan.exposure == Duration{})
    return PlanProblem{"shutter_open_ms", "the exposure must be longer than 0"};
  if (plan.exposure <= limits.longest_exposure) return std::nullopt;
  return PlanProblem{"shutter_open_ms", "an exposure of " + ms(plan.exposure) +
                                            " is longer than the shutter's " + ms(limits.longest_exposure)};
}

Problem check_impact(const ShotPlan& plan, const PlanLimits& limits) {
  const Duration impact = impact_at(plan, limits);
  if (impact < plan.exposure) return std::nullopt;
  return PlanProblem{"impact_at_ms", "the ball would meet the plate " + ms(impact) +
                                         " after the shutter opened, but the exposure ends after " +
                                         ms(plan.exposure)};
}

Problem check_count(const ShotPlan& plan, const PlanLimits& limits) {
  if (flash_count(plan) <= limits.max_flashes) return std::nullopt;
  const char* const field = plan.train == Train::gated ? "flash_count" : "period_us";
  return PlanProblem{field, std::to_string(flash_count(plan)) + " flashes are more than the " +
                                std::to_string(limits.max_flashes) + " a shot may have"};
}

}  // namespace

std::optional<PlanProblem> plan_problem(const ShotPlan& plan, const PlanLimits& limits) {
  if (plan.train != Train::free && plan.train != Train::gated)
    return PlanProblem{"train", "unknown kind of train"};
  if (auto problem = check_ranges(plan)) return problem;
  if (auto problem = check_interval(plan, limits)) return problem;
  if (auto problem = check_exposure(plan, limits)) return problem;
  auto problem = plan.train == Train::gated ? check_gated(plan, limits) : check_free(plan);
  if (!problem) problem = check_impact(plan, limits);
  return problem ? problem : check_count(plan, limits);
}

std::int32_t flash_count(const ShotPlan& plan) {
  if (!plan.code.empty()) return static_cast<std::int32_t>(plan.code.size());
  if (plan.train == Train::gated) return plan.flash_count;
  if (plan.period <= Duration{}) return kMaxFlashes + 1;
  const std::int64_t count = (plan.exposure + plan.period - Duration{1}) / plan.period;
  return static_cast<std::int32_t>(std::min<std::int64_t>(count, std::int64_t{kMaxFlashes} + 1));
}

}  // namespace strobe
