#include "host/config/plan_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

namespace strobe::host {
namespace {

constexpr config::Range kPeriod_us{100.0, 1e6};

/// As the keys of a plan file have them.
using Microseconds = std::chrono::duration<double, std::micro>;
using Milliseconds = std::chrono::duration<double, std::milli>;

template <typename Unit>
Duration to_duration(double value) {
  return Duration{std::llround(value * static_cast<double>(std::nano::den / Unit::period::den))};
}

template <typename Unit>
Duration read_duration(config::TomlTable& table, const char* key, Duration fallback, config::Range range) {
  return to_duration<Unit>(table.number_or(key, Unit(fallback).count(), range));
}

/// Of the whole train, before any flash is left out; no more than a coded train may have, and one.
std::vector<Duration> offsets(const PlanFile& plan) {
  std::vector<Duration> offsets;
  Duration offset{};
  while (offsets.size() <= kMaxCodedFlashes) {
    const bool over = plan.even.train == Train::gated
                          ? offsets.size() == static_cast<std::size_t>(plan.even.flash_count)
                          : offset >= plan.even.exposure;
    if (over) break;
    offsets.push_back(offset);
    offset += plan.intervals.empty() ? plan.even.period
                                     : plan.intervals[(offsets.size() - 1) % plan.intervals.size()];
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
void check_names(config::TomlTable& table, const PlanFile& plan, std::size_t flashes) {
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

void read_code(config::TomlTable& table, PlanFile& plan) {
  if (table.has("period_us") || table.has("spacing")) plan.intervals.clear();
  if (table.has("intervals_us")) {
    if (table.has("period_us")) table.error_at("intervals_us", "must not be given together with period_us");
    plan.intervals.clear();
    for (const double us : table.numbers_or("intervals_us", {}, kPeriod_us))
      plan.intervals.push_back(to_duration<Microseconds>(us));
    if (plan.intervals.size() > kMaxCodedFlashes)
      table.error_at("intervals_us", fmt::format("must have at most {} intervals", kMaxCodedFlashes));
  }
  if (!plan.intervals.empty())
    plan.even.period = *std::min_element(plan.intervals.begin(), plan.intervals.end());
  plan.omit = read_numbers(table, "omit", plan.omit);
  plan.only_a = read_numbers(table, "only_a", plan.only_a);
  plan.only_b = read_numbers(table, "only_b", plan.only_b);
}

/// A period alone is that of an even train, as it always was.
void read_spacing(config::TomlTable& table, PlanFile& plan) {
  const bool even = plan.spacing == Spacing::even || table.has("period_us");
  const bool coded = table.choice_or("spacing", even ? "even" : "coded", {"even", "coded"}) == "coded";
  if (table.has("spacing") && (table.has("intervals_us") || (coded && plan.coded())))
    table.error_at("spacing", "must not be given together with intervals_us, omit, only_a or only_b");
  plan.spacing = coded && !plan.coded() ? Spacing::coded : Spacing::even;
}

void check_code(config::TomlTable& table, const PlanFile& plan) {
  if (!plan.coded()) return;
  const std::size_t flashes = offsets(plan).size();
  if (flashes > kMaxCodedFlashes) {
    table.error_at(plan.intervals.empty() ? "period_us" : "intervals_us",
                   fmt::format("a coded train has at most {} flashes", kMaxCodedFlashes));
  }
  check_names(table, plan, flashes);
}

}  // namespace

ShotPlan PlanFile::shot() const {
  ShotPlan plan = even;
  const bool gated = plan.train == Train::gated;
  if (!gated) plan.gate_delay = {};
  if (!coded()) return plan;
  const std::vector<Duration> all = offsets(*this);
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (has(omit, i)) continue;
    plan.code.push_back({all[i], has(only_a, i) ? Lamps::a : has(only_b, i) ? Lamps::b : Lamps::both});
  }
  if (gated) plan.flash_count = static_cast<std::int32_t>(plan.code.size());
  return plan;
}

PlanFile read_plan_table(config::TomlTable table, const PlanFile& defaults) {
  PlanFile plan = defaults;
  ShotPlan& even = plan.even;
  const char* train = even.train == Train::gated ? "gated" : "free";
  even.train = table.choice_or("train", train, {"free", "gated"}) == "gated" ? Train::gated : Train::free;
  even.period = read_duration<Microseconds>(table, "period_us", even.period, kPeriod_us);
  even.exposure = read_duration<Milliseconds>(table, "shutter_open_ms", even.exposure, {1.0, 60000.0});
  even.gate_delay = read_duration<Milliseconds>(table, "gate_delay_ms", even.gate_delay, {0.0, 10000.0});
  even.flash_count = static_cast<int>(table.integer_or("flash_count", even.flash_count, {0.0, 100000.0}));
  even.impact_at = read_duration<Milliseconds>(table, "impact_at_ms", even.impact_at, {0.0, 60000.0});
  plan.drop_height_m = table.number_or("drop_height_m", plan.drop_height_m, {0.0, 20.0});
  const bool states = table.has("period_us") || table.has("intervals_us");
  plan.period_stated =
      plan.drop_height_m > 0.0 && (states || (plan.period_stated && !table.has("drop_height_m")));
  read_code(table, plan);
  read_spacing(table, plan);
  if (even.train == Train::gated && even.flash_count < 1) {
    table.error_at("flash_count", "a gated train needs at least 1 flash");
  }
  if (even.train == Train::free && even.flash_count != 0 && table.has("flash_count")) {
    table.error_at("flash_count",
                   "only a gated train counts its flashes; leave it out or write train = \"gated\"");
  }
  if (even.train == Train::free) even.flash_count = 0;
  const auto exposure = [&] {
    return fmt::format("shutter_open_ms is {}", Milliseconds(even.exposure).count());
  };
  if (even.train == Train::free && even.impact_at >= even.exposure)
    table.error_at("impact_at_ms", "the shutter is closed then: " + exposure());
  if (even.period > even.exposure) table.error_at("period_us", "longer than the exposure: " + exposure());
  check_code(table, plan);
  return plan;
}

Result<PlanFile> read_plan(std::string_view text, const std::string& file_name, const PlanFile& defaults) {
  config::TomlReader reader(text, file_name);
  const PlanFile plan = read_plan_table(reader.root(), defaults);
  if (const auto bad = reader.error()) return fail(bad->message);
  return plan;
}

std::string plan_to_toml(const PlanFile& plan) {
  const ShotPlan& even = plan.even;
  const bool gated = even.train == Train::gated;
  const auto us = [](Duration duration) { return Microseconds(duration).count(); };
  const auto ms = [](Duration duration) { return Milliseconds(duration).count(); };
  std::vector<double> intervals_us;
  std::transform(plan.intervals.begin(), plan.intervals.end(), std::back_inserter(intervals_us), us);
  std::string text =
      fmt::format("train = \"{}\"\nshutter_open_ms = {}\n", gated ? "gated" : "free", ms(even.exposure));
  const bool open = plan.drop_height_m > 0.0 && !plan.period_stated;
  if (plan.drop_height_m > 0.0) text += fmt::format("drop_height_m = {}\n", plan.drop_height_m);
  if (!intervals_us.empty()) text += fmt::format("intervals_us = [{}]\n", fmt::join(intervals_us, ", "));
  if (intervals_us.empty() && !open) text += fmt::format("period_us = {}\n", us(even.period));
  if (open && plan.spacing == Spacing::even) text += "spacing = \"even\"\n";
  if (plan.spacing == Spacing::coded) text += "spacing = \"coded\"\n";
  for (const auto& [key, numbers] : {std::pair("omit", &plan.omit), std::pair("only_a", &plan.only_a),
                                     std::pair("only_b", &plan.only_b)}) {
    if (!numbers->empty()) text += fmt::format("{} = [{}]\n", key, fmt::join(*numbers, ", "));
  }
  if (gated) text += fmt::format("flash_count = {}\n", even.flash_count);
  text += fmt::format("gate_delay_ms = {}\n", ms(even.gate_delay));
  if (even.impact_at > Duration{}) text += fmt::format("impact_at_ms = {}\n", ms(even.impact_at));
  return text;
}

}  // namespace strobe::host
