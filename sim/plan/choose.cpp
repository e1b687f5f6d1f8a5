#include "sim/plan/choose.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "common/units/tolerance.hpp"
#include "sim/plan/cost.hpp"

namespace strobe::sim {

namespace {

struct Rung {
  Plan plan;
  double tolerance = 0.0;
  std::size_t model = 0;  ///< index of its model's cost
};

/// The ladder's plans, and what each different model costs.
struct Ladder {
  std::vector<Rung> rungs;
  std::vector<double> costs_us;

  double cost_us(const Rung& rung) const { return costs_us[rung.model]; }
};

Result<Ladder> climb(SceneBounds& bounds, std::optional<double> tolerance, const ShootSettings& settings) {
  Ladder ladder;
  std::vector<Model> models;
  std::vector<double> tolerances(kLadder.begin(), kLadder.end());
  if (tolerance) tolerances.push_back(*tolerance);
  for (const double t : tolerances) {
    Rung rung{plan(bounds, t), t, 0};
    const auto known = std::ranges::find(models, rung.plan.model);
    rung.model = static_cast<std::size_t>(known - models.begin());
    if (known == models.end()) models.push_back(rung.plan.model);
    ladder.rungs.push_back(std::move(rung));
  }
  auto costs = shot_costs_us(bounds.scene(), models, settings);
  if (!costs) return tl::unexpected(costs.error());
  ladder.costs_us = std::move(*costs);
  return ladder;
}

/// The smallest tolerance that is met in time.
const Rung* reached_in(const Ladder& ladder, double deadline_us) {
  for (std::size_t i = 0; i < kLadder.size(); ++i) {
    if (ladder.cost_us(ladder.rungs[i]) <= deadline_us) return &ladder.rungs[i];
  }
  return nullptr;
}

std::string refusal(const Ladder& ladder, const PlanRequirement& demand, const Rung* reached) {
  const double fastest = *std::ranges::min_element(ladder.costs_us);
  std::string text =
      fmt::format("--deadline-us: no model of this scene takes {:.4g} us", *demand.deadline_us);
  if (demand.tolerance)
    text += fmt::format(" to {}: that takes {:.0f} us", tolerance_text(*demand.tolerance),
                        ladder.cost_us(ladder.rungs.back()));
  text += reached ? fmt::format("; {} is reached in time", tolerance_text(reached->tolerance))
                  : fmt::format("; the fastest takes {:.0f} us", fastest);
  return text;
}

double percent(const PerQuantity& bound, const PerQuantity& scale, reduction::Quantity q) {
  return 100.0 * bound[q] / scale[q];
}

}  // namespace

Result<ChosenPlan> choose(const Scene& scene, const PlanRequirement& demand, const ShootSettings& settings) {
  SceneBounds bounds(scene, settings);
  if (!demand.deadline_us) {
    const double tolerance = demand.tolerance.value_or(kLadder.front());
    return ChosenPlan{plan(bounds, tolerance), tolerance, {}};
  }
  const auto ladder = climb(bounds, demand.tolerance, settings);
  if (!ladder) return tl::unexpected(ladder.error());
  const Rung* reached = reached_in(*ladder, *demand.deadline_us);
  const Rung* wanted = demand.tolerance ? &ladder->rungs.back() : reached;
  if (!wanted || ladder->cost_us(*wanted) > *demand.deadline_us)
    return fail(refusal(*ladder, demand, reached));
  return ChosenPlan{wanted->plan, wanted->tolerance, ladder->cost_us(*wanted)};
}

std::string explanation(const ChosenPlan& chosen) {
  const Plan& plan = chosen.plan;
  std::string left_out;
  std::string without_effect;
  for (const PlannedEffect& e : plan.effects) {
    if (!e.present || e.needed) continue;
    if (e.bound.all_zero()) {
      without_effect += fmt::format("{}{}", without_effect.empty() ? "" : ", ", name(e.effect));
      continue;
    }
    left_out += fmt::format("{}{} ({} by at most {:.2g}%)", left_out.empty() ? "" : ", ", name(e.effect),
                            reduction::name(e.worst), percent(e.bound, plan.scale, e.worst));
  }
  std::string text = fmt::format("for {}", tolerance_text(chosen.tolerance));
  if (chosen.cost_us) text += fmt::format(" in {:.0f} us a shot", *chosen.cost_us);
  text += left_out.empty() ? ", nothing that matters is left out" : ", left out: " + left_out;
  if (!without_effect.empty()) text += "; without any effect here: " + without_effect;
  if (!left_out.empty()) {
    const reduction::Quantity most = worst(plan.left_out, plan.tolerance);
    text += fmt::format("; all together change {} by at most {:.2g}%", reduction::name(most),
                        percent(plan.left_out, plan.scale, most));
  }
  if (plan.model.contact_tolerance() != kFullContactTolerance)
    text += fmt::format("; the contact is solved to {:.0e}", plan.model.contact_tolerance());
  if (plan.sampled) {
    const reduction::Quantity most = worst(plan.sampled->largest, plan.tolerance);
    text += fmt::format(
        "; in {} sampled shots {} changes most, by {:.2g}%: with {:.0f}% confidence fewer than {:.2g}% of "
        "shots change "
        "a number by more than half of what is allowed",
        plan.sampled->shots, reduction::name(most), percent(plan.sampled->largest, plan.scale, most),
        100.0 * kConfidence, 100.0 * plan.sampled->share);
  }
  if (!plan.warning.empty()) text += "; " + plan.warning;
  return text;
}

}  // namespace strobe::sim
