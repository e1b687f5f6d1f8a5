#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "common/messages/parsed_json.hpp"
#include "common/units/tolerance.hpp"
#include "sim/commands/commands.hpp"
#include "sim/effects/choice.hpp"
#include "sim/effects/unmodelled.hpp"
#include "sim/loading/load_scene.hpp"
#include "sim/scene/model.hpp"

namespace strobe::sim {

namespace {

using nlohmann::json;
using reduction::Quantity;

/// Microseconds of a shot on this machine: the mean of the fastest of four rounds of 20 ms, or five shots.
double cost_us(Shooter shooter) {
  using Clock = std::chrono::steady_clock;
  double least_us = std::numeric_limits<double>::infinity();
  for (int round = 0; round < 4; ++round) {
    const auto start = Clock::now();
    double elapsed_s = 0.0;
    int shots = 0;
    while (shots < 5 || elapsed_s < 0.02) {
      shooter.shoot(++shots);
      elapsed_s = std::chrono::duration<double>(Clock::now() - start).count();
    }
    least_us = std::min(least_us, 1e6 * elapsed_s / shots);
  }
  return least_us;
}

/// What is shown of a scene at a tolerance.
struct Study {
  const Scene& scene;
  ModelChoice choice;
  Model present;
  PerQuantity scale;
  std::array<PerQuantity, kEffectCount> changes;  ///< by each effect alone
  double full_us = 0.0, chosen_us = 0.0;

  std::string_view status(Effect effect) const {
    if (!present.has(effect)) return "absent";
    if (!choice.model.has(effect)) return "left out";
    return is_decided(effect) ? "needed" : "always on";
  }
};

std::string change_text(double change, double scale, Quantity q) {
  if (change == 0.0) return "0";
  if (std::isinf(change)) return "a number is lost";
  const std::string_view of = unit(q);
  return fmt::format("{:.2g}{}{} ({:.2g}%)", change, of.empty() ? "" : " ", of, 100.0 * change / scale);
}

void print_text(const Study& study) {
  fmt::print("{}: what may be left out if no number is to change by more than {}\n\n", study.scene.name,
             tolerance_text(study.choice.tolerance));
  fmt::print("{:<22} {:<28} {:<18}\n", "effect", "changes by at most", "of");
  for (std::size_t i = 0; i < kEffectCount; ++i) {
    const auto effect = static_cast<Effect>(i);
    const Quantity q = worst(study.changes[i], study.choice.tolerances);
    const bool none = study.changes[i].all_zero();
    fmt::print("{:<22} {:<28} {:<18} {}\n", name(effect),
               study.present.has(effect) ? change_text(study.changes[i][q], study.scale[q], q) : "-",
               none ? "" : reduction::name(q), study.status(effect));
  }
  fmt::print("\n{:<22} {:<28} {}\n", "no model has", "changes by at most", "of");
  for (const UnmodelledTerm& term : unmodelled_terms(study.scene))
    fmt::print("{:<22} {:<28} {}\n", term.name,
               change_text(term.bound, study.scale[term.quantity], term.quantity),
               reduction::name(term.quantity));
  fmt::print("\n{}\na shot then takes {:.0f} us, with everything {:.0f} us: {:.2f} times as fast\n",
             explanation(study.choice, study.scene), study.chosen_us, study.full_us,
             study.full_us / study.chosen_us);
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

void print_json(const Study& study) {
  const ModelChoice& choice = study.choice;
  for (std::size_t i = 0; i < kEffectCount; ++i) {
    const auto effect = static_cast<Effect>(i);
    const bool none = study.changes[i].all_zero();
    const json line = {
        {"effect", name(effect)},
        {"status", study.status(effect)},
        {"worst", none ? json(nullptr) : json(reduction::name(worst(study.changes[i], choice.tolerances)))},
        {"change", per_readout(study.changes[i])}};
    fmt::print("{}\n", messages::json_text(line));
  }
  json unmodelled = json::array();
  for (const UnmodelledTerm& term : unmodelled_terms(study.scene))
    unmodelled.push_back({{"term", term.name},
                          {"quantity", reduction::name(term.quantity)},
                          {"bound", term.bound},
                          {"share", term.bound / study.scale[term.quantity]}});
  const json summary = {{"scene", study.scene.name},
                        {"tolerance", choice.tolerance},
                        {"model", model_text(choice.model)},
                        {"contact_tolerance", choice.model.contact_tolerance()},
                        {"full_us", study.full_us},
                        {"chosen_us", study.chosen_us},
                        {"tolerances", per_readout(choice.tolerances)},
                        {"shots", kSampledShots},
                        {"confidence", kConfidence},
                        {"share_below", sampled_share()},
                        {"allowed", per_readout(choice.allowed)},
                        {"changed", choice.changed ? per_readout(*choice.changed) : json(nullptr)},
                        {"no_model_has", unmodelled}};
  fmt::print("{}\n", messages::json_text(summary));
}

/// From a tolerance as typed; empty: the scene's own.
Result<double> tolerance_of(const std::string& text, const Scene& scene) {
  if (text.empty() && scene.readout.tolerance > 0.0) return scene.readout.tolerance;
  if (text.empty()) return fail("--tolerance: required, as " + scene.name + " states none of its own");
  return parse_tolerance(text).map_error([](const Error& e) { return Error{"--tolerance: " + e.message}; });
}

}  // namespace

int choose_model(const std::string& tolerance, const Scene& scene, const ShootSettings& settings,
                 Model& model) {
  if (tolerance.empty()) return 0;
  const auto parsed = tolerance_of(tolerance, scene);
  if (!parsed) return report_error(parsed.error().message, 2);
  const ModelChoice choice = ModelChooser(scene, settings).choose(*parsed);
  fmt::print(stderr, "strobe-sim: {}\n", explanation(choice, scene));
  model = choice.model;
  return 0;
}

int effects_command(const EffectsOptions& options) {
  const auto scene = load_scene(options.scene);
  if (!scene) return report_error(scene.error().message, 2);
  const auto tolerance = tolerance_of(options.tolerance, *scene);
  if (!tolerance) return report_error(tolerance.error().message, 2);
  auto full = make_shooter(options, *scene, Model::full(), options.settings());
  if (!full) return report_error(full.error().message, 2);
  if (!scene->machine.planar())
    fmt::print(stderr, "strobe-sim: {}: {}; they cannot be left out\n", scene->name,
               refusal_in_space(*scene, Model::none()).value_or(""));
  ModelChooser chooser(*scene, options.settings());
  Study study{.scene = *scene,
              .choice = chooser.choose(*tolerance),
              .present = effects_of(*scene),
              .scale = readout_scales(*scene),
              .changes = {}};
  for (std::size_t i = 0; i < kEffectCount; ++i) {
    const auto effect = static_cast<Effect>(i);
    if (study.present.has(effect)) study.changes[i] = chooser.change_by(effect);
  }
  study.full_us = cost_us(std::move(*full));
  study.chosen_us = cost_us(*make_shooter(options, *scene, study.choice.model, options.settings()));
  options.json ? print_json(study) : print_text(study);
  return std::fflush(stdout) == 0 ? 0 : report_error("standard output: not everything could be written", 1);
}

}  // namespace strobe::sim
