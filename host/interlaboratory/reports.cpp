// What laboratories report, read from JSON.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/messages/parsed_json.hpp"
#include "host/interlaboratory/comparison.hpp"
#include "host/series/wanted.hpp"
#include "host/session/shot_table.hpp"

namespace strobe::interlaboratory {

namespace {

using nlohmann::ordered_json;

std::optional<double> finite_number(const ordered_json& object, const char* key) {
  const auto found = object.find(key);
  if (found == object.end() || !found->is_number()) return std::nullopt;
  const double number = found->get<double>();
  return std::isfinite(number) ? std::optional(number) : std::nullopt;
}

bool holds(const ordered_json& object, const char* key, bool (ordered_json::*is)() const noexcept) {
  return object.is_object() && object.contains(key) && (object[key].*is)();
}

/// Nothing: it has no value, or nobody says how uncertain that is.
void add_value(LaboratoryReport& report, std::string quantity, std::string unit, const ordered_json& entry,
               const char* value_key, const char* sd_key) {
  const auto value = finite_number(entry, value_key);
  const auto expanded = finite_number(entry, "expanded_uncertainty");
  if (!value || !expanded || !(*expanded > 0.0)) return;
  const double sd = finite_number(entry, sd_key).value_or(0.0);
  report.values.push_back(
      {std::move(quantity), std::move(unit), *value, sd > 0.0 ? sd : 0.5 * *expanded, *expanded});
}

std::string unit_of(const std::string& quantity) {
  const auto known = host::find_quantity(quantity);
  return known ? std::string(host::kQuantityLabels[static_cast<std::size_t>(*known)].unit) : std::string();
}

void add_series(LaboratoryReport& report, const ordered_json& series, bool named) {
  const std::string prefix = named ? messages::value_of<std::string>(series, "series") + ": " : "";
  for (const auto& [name, entry] : series["quantities"].items())
    if (entry.is_object()) add_value(report, prefix + name, unit_of(name), entry, "mean", "total_sd");
}

/// What `strobe protocol verdict --json` computed above the level of shots: "rebound, position 2, ball 1".
void add_verdict(LaboratoryReport& report, const ordered_json& verdict) {
  for (const ordered_json& entry : verdict["values"]) {
    if (!entry.is_object() || !holds(entry, "of", &ordered_json::is_object)) continue;
    std::string quantity = messages::value_of<std::string>(entry, "name");
    const ordered_json& of = entry["of"];
    if (quantity.empty() || !messages::value_of<std::string>(of, "shot").empty()) continue;
    for (const char* key : {"position", "ball"})
      if (const auto place = messages::value_of<std::string>(of, key); !place.empty())
        quantity += fmt::format(", {} {}", key, place);
    add_value(report, quantity, messages::value_of<std::string>(entry, "unit"), entry, "value", "sd");
  }
}

Result<void> add_results(LaboratoryReport& report, const ordered_json& object, const std::string& file_name) {
  for (const ordered_json& entry : object["results"]) {
    const std::string name =
        entry.is_object() ? messages::value_of<std::string>(entry, "name") : std::string();
    if (name.empty()) return fail(file_name + ": results: an entry without a name");
    add_value(report, name, messages::value_of<std::string>(entry, "unit"), entry, "value",
              "standard_uncertainty");
  }
  return {};
}

Result<std::vector<ordered_json>> objects_of(std::string_view text, const std::string& file_name) {
  ordered_json whole = messages::parsed_json<ordered_json>(text);
  if (whole.is_object()) return std::vector{std::move(whole)};
  std::vector<ordered_json> objects;
  int number = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string_view line = text.substr(begin, end - begin);
    begin = end + 1;
    ++number;
    if (line.find_first_not_of(" \t\r") == std::string_view::npos) continue;
    objects.push_back(messages::parsed_json<ordered_json>(line));
    if (!objects.back().is_object()) return fail(fmt::format("{}:{}: no JSON object", file_name, number));
  }
  return objects;
}

}  // namespace

Result<LaboratoryReport> read_report(std::string_view text, const std::string& file_name,
                                     const std::string& laboratory) {
  const auto objects = objects_of(text, file_name);
  if (!objects) return tl::unexpected(objects.error());
  const auto is_series = [](const ordered_json& object) {
    return holds(object, "quantities", &ordered_json::is_object) && object.contains("series");
  };
  const bool named = std::ranges::count_if(*objects, is_series) > 1;
  LaboratoryReport report{laboratory, {}};
  for (const ordered_json& object : *objects) {
    if (report.laboratory.empty()) report.laboratory = messages::value_of<std::string>(object, "laboratory");
    if (is_series(object)) add_series(report, object, named);
    if (object.contains("protocol") && holds(object, "values", &ordered_json::is_array))
      add_verdict(report, object);
    if (!holds(object, "results", &ordered_json::is_array)) continue;
    if (const auto added = add_results(report, object, file_name); !added)
      return tl::unexpected(added.error());
  }
  if (report.laboratory.empty()) report.laboratory = std::filesystem::path(file_name).stem().string();
  if (report.values.empty()) return fail(file_name + ": no result with an expanded uncertainty");
  return report;
}

}  // namespace strobe::interlaboratory
