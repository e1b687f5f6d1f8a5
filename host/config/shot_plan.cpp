#include "host/config/shot_plan.hpp"

#include <fmt/format.h>

namespace strobe::host {

ShotPlan read_plan_table(config::TomlTable table, const ShotPlan& defaults) {
  ShotPlan plan = defaults;
  const char* train = defaults.train == Train::gated ? "gated" : "free";
  plan.train = table.choice_or("train", train, {"free", "gated"}) == "gated" ? Train::gated : Train::free;
  plan.period_us = table.number_or("period_us", defaults.period_us, {100.0, 1e6});
  plan.shutter_open_ms = table.number_or("shutter_open_ms", defaults.shutter_open_ms, {1.0, 60000.0});
  plan.gate_delay_ms = table.number_or("gate_delay_ms", defaults.gate_delay_ms, {0.0, 10000.0});
  plan.flash_count = static_cast<int>(table.integer_or("flash_count", defaults.flash_count, {0.0, 100000.0}));
  if (const auto impact = table.optional_number("impact_at_ms", {0.0, 60000.0})) plan.impact_at_ms = impact;
  if (plan.train == Train::gated && plan.flash_count < 1) {
    table.error_at("flash_count", "a gated train needs at least 1 flash");
  }
  if (plan.train == Train::free && plan.flash_count != 0 && table.has("flash_count")) {
    table.error_at("flash_count",
                   "only a gated train counts its flashes; leave it out or write train = \"gated\"");
  }
  if (plan.train == Train::free) plan.flash_count = 0;
  if (plan.train == Train::free && plan.impact_at_ms && *plan.impact_at_ms >= plan.shutter_open_ms) {
    table.error_at("impact_at_ms",
                   fmt::format("the shutter is closed then: shutter_open_ms is {}", plan.shutter_open_ms));
  }
  if (plan.period_us > 1000.0 * plan.shutter_open_ms) {
    table.error_at("period_us",
                   fmt::format("longer than the exposure: shutter_open_ms is {}", plan.shutter_open_ms));
  }
  return plan;
}

Result<ShotPlan> read_plan(std::string_view text, const std::string& file_name, const ShotPlan& defaults) {
  config::TomlReader reader(text, file_name);
  const ShotPlan plan = read_plan_table(reader.root(), defaults);
  if (const auto bad = reader.error()) return fail(bad->message);
  return plan;
}

std::string plan_to_toml(const ShotPlan& plan) {
  const bool gated = plan.train == Train::gated;
  std::string text = fmt::format("train = \"{}\"\nperiod_us = {}\nshutter_open_ms = {}\n",
                                 gated ? "gated" : "free", plan.period_us, plan.shutter_open_ms);
  if (gated) text += fmt::format("flash_count = {}\n", plan.flash_count);
  text += fmt::format("gate_delay_ms = {}\n", plan.gate_delay_ms);
  if (plan.impact_at_ms) text += fmt::format("impact_at_ms = {}\n", *plan.impact_at_ms);
  return text;
}

}  // namespace strobe::host
