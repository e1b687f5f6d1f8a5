#include "host/web/json/run_chart_json.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "common/messages/or_null.hpp"
#include "host/view/series_json.hpp"
#include "host/view/thesis_row.hpp"

namespace strobe::web {
namespace {

using nlohmann::ordered_json;
using reduction::kQuantityCount;
using reduction::Quantity;

constexpr double kRangeOverSd = 1.128;  // expected range of two values from a normal distribution

std::string text_of(const ordered_json& json) {
  return json.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
}

}  // namespace

std::optional<RunLimits> run_limits(const std::vector<double>& values) {
  if (values.size() < 2) return std::nullopt;
  double sum = values[0], ranges = 0.0;
  for (std::size_t i = 1; i < values.size(); ++i) {
    sum += values[i];
    ranges += std::abs(values[i] - values[i - 1]);
  }
  const double mean = sum / static_cast<double>(values.size());
  const double width = 3.0 * ranges / static_cast<double>(values.size() - 1) / kRangeOverSd;
  return RunLimits{mean, mean - width, mean + width};
}

ordered_json point_json(const ShotRow& row) {
  return {{"name", row.name},
          {"utc", row.utc},
          {"counted", !row.dry && !row.rejected},
          {"rejected", messages::or_null(row.rejected)},
          {"values", values_json(row.value, row.total_sd)}};
}

ordered_json limits_json(const host::Series& series) {
  ordered_json limits = ordered_json::object();
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    const auto of = run_limits(series.values(q));
    limits[std::string(name(q))] =
        of ? ordered_json{{"mean", of->mean}, {"lower", of->lower}, {"upper", of->upper}} : ordered_json();
  }
  return limits;
}

ordered_json thesis_json(const std::optional<thesis::Condition>& condition) {
  if (!condition) return nullptr;
  ordered_json numbers = ordered_json::object();
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    if (const auto printed = host::thesis_number(*condition, q))
      numbers[std::string(name(q))] = {{"value", printed->mean}, {"sd", printed->sd}};
  }
  return numbers;
}

std::string run_chart_text(const std::string& name, const host::Series& series, const std::vector<std::string>& points,
                           const std::optional<thesis::Condition>& condition) {
  return fmt::format("{{\"summary\":{},\"points\":[{}],\"limits\":{},\"thesis\":{}}}",
                     text_of(host::series_json(series.summary(name), condition)), fmt::join(points, ","),
                     text_of(limits_json(series)), text_of(thesis_json(condition)));
}

}  // namespace strobe::web
