#include "host/view/series_json.hpp"

#include <nlohmann/json.hpp>

#include "common/messages/parsed_json.hpp"
#include "host/series/series.hpp"
#include "host/view/series_view.hpp"

namespace strobe::host {
namespace {

using messages::or_null;
using nlohmann::ordered_json;
using reduction::kQuantityCount;
using reduction::Quantity;

std::string key(Quantity q) { return std::string(name(q)); }

ordered_json quantity_json(const QuantitySummary& s) {
  return {{"n", s.n},
          {"mean", s.n > 0 ? ordered_json(s.mean) : ordered_json()},
          {"scatter_sd", or_null(s.scatter_sd)},
          {"standard_error", or_null(s.standard_error)},
          {"shared_sd", s.n > 0 && s.shared_known ? ordered_json(s.shared_sd) : ordered_json()},
          {"total_sd", or_null(s.total_sd)},
          {"degrees_of_freedom", or_null(s.degrees_of_freedom)},
          {"expanded_uncertainty", or_null(s.expanded_uncertainty)},
          {"budget", budget_json(s.budget)}};
}

ordered_json thesis_json(const thesis::Condition& condition) {
  ordered_json numbers = ordered_json::object();
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    if (const auto printed = thesis_number(condition, q))
      numbers[key(q)] = {{"mean", printed->mean}, {"sd", printed->sd}};
  }
  return {{"spin", condition.spin}, {"angle_label_deg", condition.angle_label_deg}, {"quantities", numbers}};
}

/// Of each of two series, and the 95 % interval of that number.
ordered_json shots_json(const std::optional<ShotCount>& count) {
  if (!count) return {};
  return {{"shots", count->shots}, {"fewest", count->fewest}, {"most", count->most}};
}

std::string_view agreement_name(reduction::Agreement agrees) {
  constexpr std::array<std::string_view, 3> kNames{"yes", "no", "open"};
  return kNames[static_cast<std::size_t>(agrees)];
}

}  // namespace

ordered_json budget_json(const std::vector<BudgetLine>& lines) {
  ordered_json array = ordered_json::array();
  for (const BudgetLine& line : lines) {
    array.push_back({{"source", line.source},
                     {"type", line.type == EvaluationType::a ? "A" : "B"},
                     {"input_sd", line.input_sd > 0.0 ? ordered_json(line.input_sd) : ordered_json()},
                     {"input_unit", line.input_unit},
                     {"sensitivity", or_null(line.sensitivity)},
                     {"effect", line.effect},
                     {"share", line.share},
                     {"degrees_of_freedom", or_null(line.degrees_of_freedom)},
                     {"shared", line.shared}});
  }
  return array;
}

ordered_json series_json(const SeriesSummary& summary, const std::optional<thesis::Condition>& condition) {
  ordered_json object{{"series", summary.name}, {"counted", summary.counted}, {"rejected", summary.rejected}};
  object["until_known"] =
      messages::or_null(summary.until_known.empty() ? std::nullopt : std::optional(summary.until_known));
  ordered_json& quantities = object["quantities"] = ordered_json::object();
  for (std::size_t i = 0; i < kQuantityCount; ++i)
    quantities[key(static_cast<Quantity>(i))] = quantity_json(summary.quantities[i]);
  ordered_json& outliers = object["outliers"] = ordered_json::array();
  for (const SeriesOutlier& o : summary.outliers)
    outliers.push_back({{"shot", o.shot}, {"quantity", key(o.quantity)}, {"sds", o.sds}});
  object["alignment"] = alignment_words(summary);
  object["thesis"] = condition ? thesis_json(*condition) : ordered_json();
  return object;
}

ordered_json comparison_json(const std::string& first, const std::string& second,
                             const Comparison& comparison) {
  ordered_json object{{"compare", {first, second}}};
  ordered_json& quantities = object["quantities"] = ordered_json::object();
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    const auto& d = comparison.of(q);
    if (!d) {
      quantities[key(q)] = nullptr;
      continue;
    }
    quantities[key(q)] = {{"difference", d->difference},
                          {"standard_error", d->standard_error},
                          {"shared_sd", d->shared_sd},
                          {"total_sd", d->total_sd},
                          {"degrees_of_freedom", or_null(d->degrees_of_freedom)},
                          {"expanded_uncertainty", d->expanded_uncertainty},
                          {"decided", d->decided},
                          {"p_value", d->p_value},
                          {"difference_asked", d->asked},
                          {"power", d->power},
                          {"more_shots", {or_null(d->more_first), or_null(d->more_second)}},
                          {"shots_of_each", shots_json(d->of_each)}};
  }
  return object;
}

ordered_json monte_carlo_json(const reduction::MonteCarlo& drawn) {
  ordered_json object{{"draws", drawn.draws}, {"seed", drawn.seed}};
  ordered_json& quantities = object["quantities"] = ordered_json::object();
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    const auto& d = drawn.of(q);
    quantities[key(q)] =
        !d ? ordered_json()
           : ordered_json{
                 {"draws", d->draws},   {"mean", d->mean},     {"sd", d->sd},
                 {"low", d->low},       {"high", d->high},     {"tolerance", d->tolerance},
                 {"digits", d->digits}, {"end_sd", d->end_sd}, {"agrees", agreement_name(d->agrees)}};
  }
  return object;
}

ordered_json budget_json(const reduction::Budget& budget, const reduction::Readout& readout) {
  ordered_json object = ordered_json::object();
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    object[key(q)] = readout.value[q] ? budget_json(budget_lines(budget, q)) : ordered_json();
  }
  return object;
}

}  // namespace strobe::host
