#include "host/interlaboratory/comparison.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "common/messages/parsed_json.hpp"
#include "host/text/text.hpp"

namespace strobe::interlaboratory {

namespace {

using messages::or_null;
using nlohmann::ordered_json;

const ReportedValue* value_in(const LaboratoryReport& report, const std::string& quantity) {
  const auto found = std::ranges::find(report.values, quantity, &ReportedValue::quantity);
  return found == report.values.end() ? nullptr : &*found;
}

/// In the order in which they are first reported.
std::vector<std::string> quantities_of(const std::vector<LaboratoryReport>& reports) {
  std::vector<std::string> found;
  for (const LaboratoryReport& report : reports)
    for (const ReportedValue& value : report.values)
      if (std::ranges::find(found, value.quantity) == found.end()) found.push_back(value.quantity);
  return found;
}

Result<void> check_names(const std::vector<LaboratoryReport>& reports, const ComparisonTerms& terms) {
  std::set<std::string> names;
  for (const LaboratoryReport& report : reports)
    if (!names.insert(report.laboratory).second)
      return fail(fmt::format("two laboratories are called \"{}\": give each a name, as NAME=FILE",
                              report.laboratory));
  if (!terms.reference.empty() && !names.contains(terms.reference))
    return fail(
        fmt::format("--reference: no laboratory \"{}\" among {}", terms.reference, fmt::join(names, ", ")));
  const std::vector<std::string> known = quantities_of(reports);
  std::vector<std::string> asked = terms.quantities;
  for (const auto& [quantity, sd] : terms.assessment_sd) asked.push_back(quantity);
  for (const std::string& quantity : asked)
    if (std::ranges::find(known, quantity) == known.end())
      return fail(
          fmt::format("no laboratory reports \"{}\"; there are {}", quantity, fmt::join(known, ", ")));
  return {};
}

/// Of those that report the quantity.
Result<ComparedQuantity> gathered(const std::vector<LaboratoryReport>& reports, const std::string& quantity) {
  ComparedQuantity compared;
  compared.quantity = quantity;
  for (const LaboratoryReport& report : reports) {
    const ReportedValue* value = value_in(report, quantity);
    if (!value) continue;
    if (compared.results.empty()) compared.unit = value->unit;
    if (value->unit != compared.unit)
      return fail(fmt::format("{}: {} reports it in \"{}\", others in \"{}\"", quantity, report.laboratory,
                              value->unit, compared.unit));
    compared.results.push_back(
        {report.laboratory, value->value, value->standard_uncertainty, value->expanded_uncertainty});
  }
  return compared;
}

std::string score_cell(const std::optional<double>& score) {
  return host::right(score ? fmt::format("{:+.2f}", *score) : "-", 9);
}

/// The worst that any of its scores says; empty: it has none.
std::string_view worst_of(const Scores& scores) {
  std::optional<Performance> worst;
  const auto take = [&worst](Performance each) { worst = std::max(worst.value_or(each), each); };
  if (scores.en) take(judge_en(*scores.en));
  if (scores.z) take(judge_z(*scores.z));
  if (scores.zeta) take(judge_z(*scores.zeta));
  return worst ? name(*worst) : std::string_view("reference");
}

std::string assigned_words(const ComparedQuantity& compared) {
  const AssignedValue& assigned = compared.agreement.assigned;
  std::string words =
      fmt::format("{}: assigned {} ± {}{} ({})", compared.quantity,
                  host::rounded(assigned.value, assigned.standard_uncertainty),
                  host::rounded(assigned.expanded_uncertainty, assigned.expanded_uncertainty),
                  compared.unit.empty() ? "" : " " + compared.unit,
                  assigned.reference.empty() ? fmt::format("robust mean of {}", compared.results.size())
                                             : assigned.reference);
  if (compared.agreement.assessment_sd)
    words += fmt::format("; {} in {}", compared.agreement.with_uncertainty ? "z'" : "z",
                         host::rounded(*compared.agreement.assessment_sd, *compared.agreement.assessment_sd));
  return words;
}

ordered_json score_json(const std::optional<double>& score, Performance (*judge)(double)) {
  if (!score) return {};
  return {{"value", *score}, {"performance", name(judge(*score))}};
}

}  // namespace

Result<Comparison> compare(const std::vector<LaboratoryReport>& reports, const ComparisonTerms& terms) {
  if (reports.size() < 2) return fail("two laboratories or more are compared");
  if (const auto checked = check_names(reports, terms); !checked) return tl::unexpected(checked.error());
  Comparison comparison;
  for (const LaboratoryReport& report : reports) comparison.laboratories.push_back(report.laboratory);
  for (const std::string& quantity : quantities_of(reports)) {
    if (!terms.quantities.empty() && std::ranges::find(terms.quantities, quantity) == terms.quantities.end())
      continue;
    auto compared = gathered(reports, quantity);
    if (!compared) return tl::unexpected(compared.error());
    const auto sd = terms.assessment_sd.find(quantity);
    const auto agreement = compare(
        compared->results,
        Terms{terms.reference, sd == terms.assessment_sd.end() ? std::nullopt : std::optional(sd->second)});
    if (!agreement) {
      comparison.remarks.push_back(
          fmt::format("{}: not compared: {}", quantity,
                      compared->results.size() < 2 ? "one laboratory alone reports it"
                      : terms.reference.empty()    ? "no consensus, more than half of the values are equal"
                                                   : "the reference does not report it"));
      continue;
    }
    compared->agreement = *agreement;
    comparison.quantities.push_back(std::move(*compared));
  }
  if (comparison.quantities.empty()) return fail("the laboratories have no quantity in common");
  return comparison;
}

bool all_agree(const Comparison& comparison) {
  const auto is_bad = [](const Scores& scores) {
    return worst_of(scores) == name(Performance::unsatisfactory);
  };
  return std::ranges::none_of(comparison.quantities, [&](const ComparedQuantity& each) {
    return std::ranges::any_of(each.agreement.scores, is_bad);
  });
}

std::vector<std::string> comparison_text(const Comparison& comparison) {
  std::vector<std::string> lines;
  for (const ComparedQuantity& each : comparison.quantities) {
    lines.push_back(assigned_words(each));
    lines.push_back(host::left("  laboratory", 26) + host::right("value", 12) + host::right("± 95 %", 12) +
                    host::right("E_n", 9) + host::right(each.agreement.with_uncertainty ? "z'" : "z", 9) +
                    host::right("zeta", 9));
    for (std::size_t i = 0; i < each.results.size(); ++i) {
      const LaboratoryResult& result = each.results[i];
      const Scores& scores = each.agreement.scores[i];
      lines.push_back(
          host::left("  " + result.laboratory, 26) +
          host::right(host::rounded(result.value, result.standard_uncertainty), 12) +
          host::right(host::rounded(result.expanded_uncertainty, result.expanded_uncertainty), 12) +
          score_cell(scores.en) + score_cell(scores.z) + score_cell(scores.zeta) + "  " +
          std::string(worst_of(scores)));
    }
    lines.emplace_back();
  }
  return lines;
}

std::string comparison_json(const ComparedQuantity& compared) {
  const AssignedValue& assigned = compared.agreement.assigned;
  ordered_json object{
      {"quantity", compared.quantity},
      {"unit", compared.unit},
      {"assigned",
       {{"value", assigned.value},
        {"standard_uncertainty", assigned.standard_uncertainty},
        {"expanded_uncertainty", assigned.expanded_uncertainty},
        {"reference", assigned.reference.empty() ? ordered_json() : ordered_json(assigned.reference)}}},
      {"assessment_sd", or_null(compared.agreement.assessment_sd)},
      {"with_uncertainty", compared.agreement.with_uncertainty}};
  ordered_json& results = object["results"] = ordered_json::array();
  for (std::size_t i = 0; i < compared.results.size(); ++i) {
    const LaboratoryResult& result = compared.results[i];
    const Scores& scores = compared.agreement.scores[i];
    results.push_back({{"laboratory", result.laboratory},
                       {"value", result.value},
                       {"standard_uncertainty", result.standard_uncertainty},
                       {"expanded_uncertainty", result.expanded_uncertainty},
                       {"en", score_json(scores.en, judge_en)},
                       {"z", score_json(scores.z, judge_z)},
                       {"zeta", score_json(scores.zeta, judge_z)}});
  }
  return messages::json_text(object);
}

figures::Figure comparison_figure(const Comparison& comparison) {
  figures::Figure figure{
      .title = "Between laboratories",
      .caption = "points: results with their expanded uncertainties (95 %); band: the assigned value's",
      .columns = static_cast<int>(std::clamp<std::size_t>(comparison.quantities.size(), 1, 3))};
  for (const ComparedQuantity& each : comparison.quantities) {
    const AssignedValue& assigned = each.agreement.assigned;
    const bool first = figure.panels.empty();
    figures::Series results{.name = each.quantity + " results",
                            .legend = first ? "laboratory" : "",
                            .stroke = figures::Stroke::points,
                            .colour = figures::colours::kMeasured};
    figures::Series level{.name = each.quantity + " assigned",
                          .legend = first ? "assigned value" : "",
                          .stroke = figures::Stroke::solid,
                          .colour = figures::colours::kIntegration};
    for (const LaboratoryResult& result : each.results) {
      const auto place = std::ranges::find(comparison.laboratories, result.laboratory);
      results.points.push_back({static_cast<double>(place - comparison.laboratories.begin() + 1),
                                result.value, result.value - result.expanded_uncertainty,
                                result.value + result.expanded_uncertainty});
    }
    for (const double x : {0.5, static_cast<double>(comparison.laboratories.size()) + 0.5})
      level.points.push_back({x, assigned.value, assigned.value - assigned.expanded_uncertainty,
                              assigned.value + assigned.expanded_uncertainty});
    figure.panels.push_back({.y_label = each.unit.empty() ? each.quantity : each.quantity + ", " + each.unit,
                             .series = {std::move(level), std::move(results)}});
  }
  return figure;
}

}  // namespace strobe::interlaboratory
