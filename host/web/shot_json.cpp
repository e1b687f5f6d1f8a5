#include "host/web/shot_json.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <string_view>
#include <vector>

#include "common/messages/parsed_json.hpp"
#include "common/reduction/uncertainty.hpp"
#include "host/config/notes.hpp"
#include "host/series/select.hpp"
#include "host/series/series.hpp"
#include "host/session/shot_table.hpp"
#include "host/view/series_json.hpp"
#include "host/view/series_view.hpp"

namespace strobe::web {
namespace {

using messages::or_null;
using nlohmann::ordered_json;
using reduction::Flag;
using reduction::kQuantityCount;
using reduction::Quantity;

ordered_json word_or_null(const std::string& word) {
  return word.empty() ? ordered_json() : ordered_json(word);
}

std::vector<std::string> names_of(const reduction::FlagSet& flags) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < reduction::kFlagCount; ++i)
    if (flags.has(static_cast<Flag>(i))) names.emplace_back(reduction::kFlagNames[i]);
  return names;
}

/// An object of what `of` makes of each quantity, by its name.
template <typename Of>
ordered_json by_quantity(Of of) {
  ordered_json object = ordered_json::object();
  for (const std::string_view quantity : reduction::kQuantityNames)
    object[std::string(quantity)] = of(static_cast<Quantity>(object.size()));
  return object;
}

ordered_json points_json(std::span<const ShotRow> rows) {
  ordered_json points = ordered_json::array();
  for (const ShotRow& row : rows)
    if (!row.dry)
      points.push_back({{"name", row.name},
                        {"utc", row.utc},
                        {"counted", !row.rejected},
                        {"rejected", or_null(row.rejected)},
                        {"values", values_json(row.value, row.total_sd)}});
  return points;
}

ordered_json limits_json(std::span<const ShotRow> rows) {
  return by_quantity([rows](Quantity q) {
    std::vector<double> values;
    for (const ShotRow& row : rows)
      if (!row.dry && !row.rejected && row.value[q]) values.push_back(*row.value[q]);
    const auto limits = host::individuals_limits(values);
    return limits ? ordered_json{{"mean", limits->mean}, {"lower", limits->lower}, {"upper", limits->upper}}
                  : ordered_json();
  });
}

ordered_json printed_json(const thesis::Condition& condition) {
  ordered_json object = ordered_json::object();
  for (std::size_t i = 0; i < kQuantityCount; ++i)
    if (const auto printed = host::thesis_number(condition, static_cast<Quantity>(i)))
      object[std::string(reduction::kQuantityNames[i])] = {{"value", printed->mean}, {"sd", printed->sd}};
  return object;
}

}  // namespace

ShotRow shot_row(const host::Shot& shot) {
  const reduction::Readout& readout = shot.readout;
  ShotRow row;
  row.name = shot.name;
  row.key = shot.key();
  row.utc = shot.utc;
  row.dry = shot.dry;
  row.rejected = shot.rejected;
  row.flags = names_of(readout.flags);
  if (readout.regime) row.regime = strobe::name(*readout.regime);
  row.digitization = host::digitization_word(shot);
  row.value = readout.value;
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    row.total_sd[q] = reduction::total_sd(readout, q);
  }
  row.spin = host::value_of(shot, "spin");
  row.surface = host::value_of(shot, "surface_name");
  row.ball = host::value_of(shot, "ball_name");
  row.angle_deg = host::note_number(readout.record, "angle_deg");
  return row;
}

ordered_json values_json(const reduction::Quantities& value, const reduction::Quantities& total_sd) {
  return by_quantity([&](Quantity q) {
    return ordered_json{{"value", or_null(value[q])}, {"sd", or_null(total_sd[q])}};
  });
}

ordered_json shot_json(const ShotRow& row, const std::optional<std::string>& session) {
  return {{"session", or_null(session)},
          {"name", row.name},
          {"boot_id", fmt::format("{:x}", static_cast<std::uint64_t>(row.key.boot_id))},
          {"shot_id", row.key.shot_id},
          {"utc", row.utc},
          {"dry", row.dry},
          {"counted", !row.dry && !row.rejected},
          {"rejected", or_null(row.rejected)},
          {"flags", row.flags},
          {"regime", word_or_null(row.regime)},
          {"digitization", word_or_null(row.digitization)},
          {"values", values_json(row.value, row.total_sd)},
          {"spin", word_or_null(row.spin)},
          {"angle_deg", or_null(row.angle_deg)},
          {"surface", word_or_null(row.surface)},
          {"ball", word_or_null(row.ball)}};
}

ordered_json quantities_json() {
  ordered_json quantities = ordered_json::array();
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    quantities.push_back({{"name", name(q)},
                          {"label", host::kQuantityLabels[i].words},
                          {"unit", host::kQuantityLabels[i].unit},
                          {"essential", host::is_essential(q)}});
  }
  return quantities;
}

ordered_json series_page_json(const host::SeriesSummary& summary,
                              const std::optional<thesis::Condition>& condition,
                              std::span<const ShotRow> rows) {
  return {{"summary", host::series_json(summary, condition)},
          {"points", points_json(rows)},
          {"limits", limits_json(rows)},
          {"thesis", condition ? printed_json(*condition) : ordered_json()}};
}

std::optional<thesis::Condition> condition_of(std::span<const ShotRow> rows) {
  const ShotRow* first = nullptr;
  for (const ShotRow& row : rows) {
    if (row.dry) continue;
    if (row.spin.empty() || !row.angle_deg) return std::nullopt;
    if (first == nullptr) first = &row;
    if (row.spin != first->spin || *row.angle_deg != *first->angle_deg) return std::nullopt;
  }
  return first != nullptr ? thesis::shipped_condition(first->spin, *first->angle_deg) : std::nullopt;
}

}  // namespace strobe::web
