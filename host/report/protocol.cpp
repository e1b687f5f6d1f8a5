// The test by a protocol as a customer reads it: the verdict, what it rests on, which shots and why not the
// others.
#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "host/protocol/evaluation.hpp"
#include "host/report/sections.hpp"

namespace strobe::report {

namespace {

using protocol::Computed;
using protocol::Evaluation;
using protocol::Outcome;
using protocol::Protocol;

struct ProtocolResult {
  const Protocol& protocol;
  Evaluation evaluation;
};

ProtocolResult result_of(const Content& content) {
  std::vector<host::Shot> shots;
  for (const ReportShot& each : content.shots) shots.push_back(*each.in_series);
  const auto& [protocol, text, seed] = *content.input.protocol;
  return {protocol, protocol::evaluate(protocol, seed, shots)};
}

std::string words_of(const ProtocolResult& result, const std::string& name) {
  const auto found = std::ranges::find(result.protocol.computed, name, &Computed::name);
  return found == result.protocol.computed.end() || found->words.empty() ? name : found->words;
}

std::string unit_of(const ProtocolResult& result, const std::string& name) {
  const auto found = std::ranges::find(result.protocol.computed, name, &Computed::name);
  return found == result.protocol.computed.end() ? "" : found->unit;
}

std::string place_words(const protocol::Cell& cell) {
  return cell.position.empty() ? "all" : protocol::words(cell);
}

const protocol::Value* value_of(const Evaluation& evaluation, const protocol::Verdict& verdict) {
  for (const protocol::Value& value : evaluation.values)
    if (value.name == verdict.requirement && value.cell == verdict.cell && value.shot.empty()) return &value;
  return nullptr;
}

Table verdicts_table(const ProtocolResult& result) {
  Table table{
      .key = "verdicts",
      .title = "Requirements",
      .columns = {text_column("requirement"), text_column("of"), text_column("clause"), text_column("limits"),
                  text_column("unit"), number_column("result", "result ± U"), text_column("verdict"),
                  number_column("risk", "probability of being wrong", "%"), text_column("why")}};
  for (const protocol::Verdict& verdict : result.evaluation.verdicts) {
    const auto asked =
        std::ranges::find(result.protocol.requirements, verdict.requirement, &protocol::Requirement::name);
    const protocol::Value* value = value_of(result.evaluation, verdict);
    table.rows.push_back(
        {{words_of(result, verdict.requirement), place_words(verdict.cell), asked->clause,
          asked->categories.empty() ? protocol::words(asked->limits) : "classified",
          unit_of(result, verdict.requirement),
          value ? expanded_cell(value->value, value->expanded) : Cell("-"),
          verdict.category.empty() ? std::string(name(verdict.outcome)) : verdict.category,
          verdict.risk ? Cell(fmt::format("{:.2g}", 100.0 * *verdict.risk), 100.0 * *verdict.risk)
                       : Cell("-"),
          verdict.why}});
  }
  return table;
}

/// What stands above the single shots.
Table values_table(const ProtocolResult& result) {
  Table table{
      .key = "computed",
      .title = "What was computed",
      .columns = {text_column("number"), text_column("of"), text_column("formula"), text_column("unit"),
                  number_column("value", "value ± U"), number_column("freedom", "degrees of freedom"),
                  text_column("largest", "largest part of the uncertainty")}};
  for (const protocol::Value& value : result.evaluation.values) {
    if (!value.shot.empty()) continue;
    const auto asked = std::ranges::find(result.protocol.computed, value.name, &Computed::name);
    const auto largest = std::ranges::max_element(value.budget, {}, &host::BudgetLine::share);
    table.rows.push_back(
        {{words_of(result, value.name), place_words(value.cell), asked->formula.text, asked->unit,
          expanded_cell(value.value, value.expanded), freedom_cell(value.degrees_of_freedom),
          largest == value.budget.end()
              ? std::string("-")
              : fmt::format("{}, {:.0f} %", largest->source, 100.0 * largest->share)}});
  }
  return table;
}

std::string_view words(protocol::Use use) {
  switch (use) {
    case protocol::Use::counts:
      return "counts";
    case protocol::Use::discarded:
      return "conditioning: not counted";
    case protocol::Use::not_conforming:
      return "does not conform: fired again";
    case protocol::Use::rejected:
      return "no readout: fired again";
    case protocol::Use::surplus:
      return "more than asked for: not counted";
  }
  return "";
}

Table uses_table(const ProtocolResult& result) {
  Table table{.key = "uses",
              .title = "Shots",
              .columns = {text_column("shot"), text_column("of"), text_column("use"), text_column("why")}};
  for (const protocol::UsedShot& shot : result.evaluation.shots)
    table.rows.push_back({{shot.shot, place_words(shot.cell), words(shot.use), shot.why}});
  return table;
}

std::string source_words(const protocol::ProtocolSource& source) {
  const std::string_view read = source.read == protocol::SourceRead::whole     ? "read as a whole"
                                : source.read == protocol::SourceRead::summary ? "read in a summary"
                                                                               : "not read";
  return fmt::format("{}, {} ({}: {})", source.document, source.edition, read, source.where);
}

}  // namespace

Section test_by_protocol(const Content& content) {
  Section section{"protocol", "Test by protocol"};
  if (!content.input.protocol) return section;
  const ProtocolResult result = result_of(content);
  const Protocol& asked = result.protocol;
  section.blocks.emplace_back(Facts{
      "test",
      "",
      {fact("protocol", "Protocol", asked.title), fact("document", "Follows", source_words(asked.source)),
       fact("outcome", "Verdict", std::string(name(result.evaluation.outcome))),
       fact("why", "", result.evaluation.why)}});
  if (!asked.report.empty()) section.blocks.emplace_back(Paragraph{"about", asked.report});
  section.blocks.emplace_back(verdicts_table(result));
  section.blocks.emplace_back(values_table(result));
  section.blocks.emplace_back(uses_table(result));
  std::string missing;
  for (const std::string& sentence : asked.not_measured) append(missing, sentence, " ");
  if (!missing.empty())
    section.blocks.emplace_back(Paragraph{"not_measured", "Not part of this test: " + missing});
  return section;
}

}  // namespace strobe::report
