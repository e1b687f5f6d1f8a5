#include "host/config/shot_plan.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

namespace strobe::host {
namespace {

/// Of the whole train, before any flash is left out; no more than a coded train may have, and one.
std::vector<double> offsets_us(const ShotPlan& plan) {
  std::vector<double> offsets;
  double offset_us = 0.0;
  while (offsets.size() <= kMaxCodedFlashes) {
    const bool over = plan.train == Train::gated
                          ? offsets.size() == static_cast<std::size_t>(plan.flash_count)
                          : offset_us >= 1000.0 * plan.shutter_open_ms;
    if (over) break;
    offsets.push_back(offset_us);
    offset_us += plan.intervals_us.empty()
                     ? plan.period_us
                     : plan.intervals_us[(offsets.size() - 1) % plan.intervals_us.size()];
  }
  return offsets;
}

bool has(const std::vector<int>& numbers, std::size_t number) {
  return std::binary_search(numbers.begin(), numbers.end(), static_cast<int>(number));
}

std::vector<int> read_numbers(config::TomlTable& table, const char* key, const std::vector<int>& fallback) {
  if (!table.has(key)) return fallback;
  std::vector<int> numbers;
  for (const double number : table.numbers_or(key, {}, {0.0, static_cast<double>(kMaxCodedFlashes - 1)})) {
    if (number != std::floor(number)) table.error_at(key, "flashes have whole numbers, from 0");
    numbers.push_back(static_cast<int>(number));
  }
  std::sort(numbers.begin(), numbers.end());
  if (std::adjacent_find(numbers.begin(), numbers.end()) != numbers.end())
    table.error_at(key, "names a flash twice");
  return numbers;
}

/// Each flash named must be in the train, and in one list only.
void check_names(config::TomlTable& table, const ShotPlan& plan, std::size_t flashes) {
  std::vector<int> seen;
  for (const auto& [key, numbers] : {std::pair("omit", &plan.omit), std::pair("only_a", &plan.only_a),
                                     std::pair("only_b", &plan.only_b)}) {
    for (const int number : *numbers) {
      if (static_cast<std::size_t>(number) >= flashes)
        table.error_at(key, fmt::format("no flash {} in a train of {}", number, flashes));
      if (std::find(seen.begin(), seen.end(), number) != seen.end())
        table.error_at(key, fmt::format("flash {} is named in another list as well", number));
    }
    seen.insert(seen.end(), numbers->begin(), numbers->end());
  }
  if (plan.omit.size() >= flashes) table.error_at("omit", "leaves no flash");
}

void read_code(config::TomlTable& table, ShotPlan& plan) {
  if (table.has("period_us")) plan.intervals_us.clear();
  if (table.has("intervals_us")) {
    if (table.has("period_us")) table.error_at("intervals_us", "instead of period_us, not beside it");
    plan.intervals_us = table.numbers_or("intervals_us", {}, {100.0, 1e6});
    if (plan.intervals_us.size() > kMaxCodedFlashes)
      table.error_at("intervals_us", fmt::format("more than {}", kMaxCodedFlashes));
  }
  if (!plan.intervals_us.empty())
    plan.period_us = *std::min_element(plan.intervals_us.begin(), plan.intervals_us.end());
  plan.omit = read_numbers(table, "omit", plan.omit);
  plan.only_a = read_numbers(table, "only_a", plan.only_a);
  plan.only_b = read_numbers(table, "only_b", plan.only_b);
}

void check_code(config::TomlTable& table, const ShotPlan& plan) {
  if (!plan.coded()) return;
  const std::size_t flashes = offsets_us(plan).size();
  if (flashes > kMaxCodedFlashes) {
    table.error_at(plan.intervals_us.empty() ? "period_us" : "intervals_us",
                   fmt::format("a coded train has at most {} flashes", kMaxCodedFlashes));
  }
  check_names(table, plan, flashes);
}

}  // namespace

std::vector<CodedFlash> train_code(const ShotPlan& plan) {
  std::vector<CodedFlash> code;
  if (!plan.coded()) return code;
  const std::vector<double> offsets = offsets_us(plan);
  for (std::size_t i = 0; i < offsets.size(); ++i) {
    if (has(plan.omit, i)) continue;
    code.push_back({offsets[i], has(plan.only_a, i)   ? FlashLamps::a
                                : has(plan.only_b, i) ? FlashLamps::b
                                                      : FlashLamps::both});
  }
  return code;
}

ShotPlan read_plan_table(config::TomlTable table, const ShotPlan& defaults) {
  ShotPlan plan = defaults;
  const char* train = defaults.train == Train::gated ? "gated" : "free";
  plan.train = table.choice_or("train", train, {"free", "gated"}) == "gated" ? Train::gated : Train::free;
  plan.period_us = table.number_or("period_us", defaults.period_us, {100.0, 1e6});
  plan.shutter_open_ms = table.number_or("shutter_open_ms", defaults.shutter_open_ms, {1.0, 60000.0});
  plan.gate_delay_ms = table.number_or("gate_delay_ms", defaults.gate_delay_ms, {0.0, 10000.0});
  plan.flash_count = static_cast<int>(table.integer_or("flash_count", defaults.flash_count, {0.0, 100000.0}));
  if (const auto impact = table.optional_number("impact_at_ms", {0.0, 60000.0})) plan.impact_at_ms = impact;
  read_code(table, plan);
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
  check_code(table, plan);
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
  std::string text =
      fmt::format("train = \"{}\"\nshutter_open_ms = {}\n", gated ? "gated" : "free", plan.shutter_open_ms);
  text += plan.intervals_us.empty()
              ? fmt::format("period_us = {}\n", plan.period_us)
              : fmt::format("intervals_us = [{}]\n", fmt::join(plan.intervals_us, ", "));
  for (const auto& [key, numbers] : {std::pair("omit", &plan.omit), std::pair("only_a", &plan.only_a),
                                     std::pair("only_b", &plan.only_b)}) {
    if (!numbers->empty()) text += fmt::format("{} = [{}]\n", key, fmt::join(*numbers, ", "));
  }
  if (gated) text += fmt::format("flash_count = {}\n", plan.flash_count);
  text += fmt::format("gate_delay_ms = {}\n", plan.gate_delay_ms);
  if (plan.impact_at_ms) text += fmt::format("impact_at_ms = {}\n", *plan.impact_at_ms);
  return text;
}

}  // namespace strobe::host
