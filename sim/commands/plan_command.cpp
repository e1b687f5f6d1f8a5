#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "common/messages/parsed_json.hpp"
#include "common/units/tolerance.hpp"
#include "sim/commands/command_line.hpp"
#include "sim/commands/commands.hpp"
#include "sim/loading/scene_files.hpp"
#include "sim/plan/choose.hpp"
#include "sim/plan/cost.hpp"
#include "sim/plan/unmodelled.hpp"
#include "sim/scene/model_text.hpp"

namespace strobe::sim {

namespace {

using nlohmann::json;
using reduction::Quantity;

/// What every shot of the scene costs: with all effects, as planned, and with all but each effect.
struct Costs {
  double full_us = 0.0;
  double planned_us = 0.0;
  std::array<double, kEffectCount> effect_us{};  ///< 0: the scene has it not
};

Result<Costs> measure(const Scene& scene, const Plan& plan, const ShootSettings& settings) {
  std::vector<Model> models{Model::full(), plan.model};
  std::vector<std::size_t> effects;
  for (const PlannedEffect& e : plan.effects) {
    if (!e.present) continue;
    effects.push_back(static_cast<std::size_t>(e.effect));
    models.push_back(Model::full().without(e.effect));
  }
  const auto costs = shot_costs_us(scene, models, settings);
  if (!costs) return tl::unexpected(costs.error());
  Costs result{(*costs)[0], (*costs)[1], {}};
  for (std::size_t i = 0; i < effects.size(); ++i)
    result.effect_us[effects[i]] = std::max(0.0, (*costs)[0] - (*costs)[i + 2]);
  return result;
}

std::string bound_text(double bound, double scale, Quantity q) {
  if (bound == 0.0) return "0";
  if (std::isinf(bound)) return "none";
  const std::string_view of = unit(q);
  return fmt::format("{:.2g}{}{} ({:.2g}%)", bound, of.empty() ? "" : " ", of, 100.0 * bound / scale);
}

std::string_view status(const PlannedEffect& e) {
  if (!e.present) return "absent";
  if (!e.needed) return "left out";
  return is_decided(e.effect) ? "needed" : "always on";
}

void print_claims(const Plan& plan) {
  fmt::print("\nthe contact is solved to {:.0e}", plan.model.contact_tolerance());
  if (!plan.sampled) {
    fmt::print("; nothing that matters is left out\n");
    return;
  }
  const SampledClaim& claim = *plan.sampled;
  const Quantity most = worst(claim.largest, plan.tolerance);
  fmt::print(
      "; of {} sampled shots none changes a number by more than half of what is allowed,\n{} most, by {}: "
      "with {:.0f}% confidence fewer than {:.2g}% of shots do\n",
      claim.shots, reduction::name(most), bound_text(claim.largest[most], plan.scale[most], most),
      100.0 * kConfidence, 100.0 * claim.share);
}

void print_unmodelled(const Scene& scene, const Plan& plan) {
  fmt::print("\n{:<22} {:<28} {}\n", "no model has", "changes by at most", "of");
  for (const UnmodelledTerm& term : unmodelled_terms(scene))
    fmt::print("{:<22} {:<28} {}\n", term.name,
               bound_text(term.bound, plan.scale[term.quantity], term.quantity),
               reduction::name(term.quantity));
}

void print_all(const PerQuantity& bound, const Plan& plan) {
  for (std::size_t i = 0; i < reduction::kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    fmt::print("    {:<18} {}\n", reduction::name(q), bound_text(bound[q], plan.scale[q], q));
  }
}

void print_table(const Scene& scene, const Plan& plan, double tolerance, const Costs& costs, bool all) {
  fmt::print("{}: what may be left out if no number is to change by more than {}\n\n", scene.name,
             tolerance_text(tolerance));
  fmt::print("{:<22} {:<28} {:<18} {:<9} {:>9}\n", "effect", "changes by at most", "of", "", "cost, us");
  for (const PlannedEffect& e : plan.effects) {
    if (!e.present) {
      fmt::print("{:<22} {:<28} {:<18} {:<9} {:>9}\n", name(e.effect), "-", "", "absent", "-");
      continue;
    }
    const bool none = e.bound.all_zero();
    fmt::print("{:<22} {:<28} {:<18} {:<9} {:>9.1f}\n", name(e.effect),
               bound_text(e.bound[e.worst], plan.scale[e.worst], e.worst),
               none ? std::string_view{} : reduction::name(e.worst), status(e),
               costs.effect_us[static_cast<std::size_t>(e.effect)]);
    if (all) print_all(e.bound, plan);
  }
  if (all) {
    fmt::print("images that come and go\n");
    print_all(plan.threshold_steps, plan);
    fmt::print("all that is left out\n");
    print_all(plan.left_out, plan);
  }
  print_unmodelled(scene, plan);
  print_claims(plan);
  fmt::print("a shot takes {:.0f} us as planned, {:.0f} us with everything: {:.2f} times as fast\n",
             costs.planned_us, costs.full_us, costs.full_us / costs.planned_us);
  if (!plan.warning.empty()) fmt::print("nothing that displaces an image may go: {}\n", plan.warning);
}

/// Infinite numbers are null.
json per_readout(const PerQuantity& values) {
  json object = json::object();
  for (std::size_t i = 0; i < reduction::kQuantityCount; ++i) {
    json& value = object[std::string(reduction::kQuantityNames[i])];
    if (std::isfinite(values[i])) value = values[i];
  }
  return object;
}

json sampled_json(const Plan& plan) {
  if (!plan.sampled) return nullptr;
  return {{"shots", plan.sampled->shots},
          {"beyond", 0},
          {"confidence", kConfidence},
          {"share_below", plan.sampled->share},
          {"allowed", per_readout(plan.sampled->allowed)},
          {"largest", per_readout(plan.sampled->largest)}};
}

json unmodelled_json(const Scene& scene, const Plan& plan) {
  json all = json::array();
  for (const UnmodelledTerm& term : unmodelled_terms(scene))
    all.push_back({{"term", term.name},
                   {"quantity", reduction::name(term.quantity)},
                   {"bound", term.bound},
                   {"share", term.bound / plan.scale[term.quantity]}});
  return all;
}

void print_json(const Scene& scene, const Plan& plan, double tolerance, const Costs& costs) {
  for (const PlannedEffect& e : plan.effects) {
    json line = {{"effect", name(e.effect)}, {"present", e.present}, {"needed", e.needed}};
    line["status"] = status(e);
    line["worst"] = e.bound.all_zero() ? json(nullptr) : json(reduction::name(e.worst));
    line["bound"] = per_readout(e.bound);
    line["cost_us"] = costs.effect_us[static_cast<std::size_t>(e.effect)];
    fmt::print("{}\n", messages::json_text(line));
  }
  const json summary = {{"scene", scene.name},
                        {"tolerance", tolerance},
                        {"model", model_text(plan.model)},
                        {"full_us", costs.full_us},
                        {"planned_us", costs.planned_us},
                        {"speed_up", costs.full_us / costs.planned_us},
                        {"tolerances", per_readout(plan.tolerance)},
                        {"left_out", per_readout(plan.left_out)},
                        {"images_come_and_go", per_readout(plan.threshold_steps)},
                        {"warning", plan.warning},
                        {"contact_tolerance", plan.model.contact_tolerance()},
                        {"sampled", sampled_json(plan)},
                        {"no_model_has", unmodelled_json(scene, plan)}};
  fmt::print("{}\n", messages::json_text(summary));
}

}  // namespace

Result<PlanRequirement> parse_requirement(const std::string& tolerance,
                                          const std::optional<double>& deadline_us, const Scene& scene) {
  PlanRequirement demand;
  if (!tolerance.empty()) {
    const auto parsed = parse_tolerance(tolerance);
    if (!parsed) return fail("--tolerance: " + parsed.error().message);
    demand.tolerance = *parsed;
  } else if (scene.readout.tolerance > 0.0) {
    demand.tolerance = scene.readout.tolerance;
  }
  if (deadline_us && !(*deadline_us > 0.0 && std::isfinite(*deadline_us)))
    return fail("--deadline-us: must be above 0");
  demand.deadline_us = deadline_us;
  return demand;
}

int plan_command(const PlanOptions& options) {
  const auto scene = load_scene(options.scene);
  if (!scene) return report_error(scene.error().message, 2);
  const auto demand = parse_requirement(options.tolerance, {}, *scene);
  if (!demand) return report_error(demand.error().message, 2);
  if (!demand->tolerance)
    return report_error("--tolerance: required, as " + scene->name + " states none of its own", 2);
  const ShootSettings settings{.period = from_milliseconds(options.period_ms),
                               .exposure = from_milliseconds(options.exposure_ms)};
  if (const auto shooter = Shooter::make(*scene, 1, Model::full(), settings); !shooter) {
    std::string message = shooter.error().message;
    message.insert(message.find(':'), "-ms");  // the option's name
    return report_error("--" + message, 2);
  }
  SceneBounds bounds(*scene, settings);
  const Plan planned = plan(bounds, *demand->tolerance);
  const auto costs = measure(*scene, planned, settings);
  if (!costs) return report_error(costs.error().message, 1);
  if (options.json) {
    print_json(*scene, planned, *demand->tolerance, *costs);
  } else {
    print_table(*scene, planned, *demand->tolerance, *costs, options.all);
  }
  return std::fflush(stdout) == 0 ? 0 : report_error("not everything could be written", 1);
}

}  // namespace strobe::sim
