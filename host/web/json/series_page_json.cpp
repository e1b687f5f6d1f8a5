#include "host/web/json/series_page_json.hpp"

#include <nlohmann/json.hpp>
#include <vector>

#include "common/data/thesis_data.hpp"
#include "common/messages/parsed_json.hpp"
#include "host/series/series.hpp"
#include "host/view/series_json.hpp"
#include "host/view/series_view.hpp"

namespace strobe::web {
namespace {

using nlohmann::ordered_json;
using reduction::kQuantityCount;
using reduction::Quantity;

ordered_json points_json(std::span<const ShotRow> rows) {
  ordered_json points = ordered_json::array();
  for (const ShotRow& row : rows) {
    if (row.dry) continue;
    points.push_back({{"name", row.name},
                      {"utc", row.utc},
                      {"counted", !row.rejected},
                      {"rejected", messages::or_null(row.rejected)},
                      {"values", values_json(row.value, row.total_sd)}});
  }
  return points;
}

ordered_json limits_json(std::span<const ShotRow> rows) {
  ordered_json object = ordered_json::object();
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    std::vector<double> values;
    for (const ShotRow& row : rows)
      if (!row.dry && !row.rejected && row.value[q]) values.push_back(*row.value[q]);
    const auto limits = host::individuals_limits(values);
    object[std::string(name(q))] =
        limits ? ordered_json{{"mean", limits->mean}, {"lower", limits->lower}, {"upper", limits->upper}}
               : ordered_json();
  }
  return object;
}

ordered_json printed_json(const thesis::Condition& condition) {
  ordered_json object = ordered_json::object();
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    if (const auto printed = host::thesis_number(condition, q))
      object[std::string(name(q))] = {{"value", printed->mean}, {"sd", printed->sd}};
  }
  return object;
}

}  // namespace

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
