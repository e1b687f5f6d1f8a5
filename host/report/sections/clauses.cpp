// Where what ISO/IEC 17025 asks of a report stands in this one.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "host/report/sections/parts.hpp"
#include "host/report/sections/sections.hpp"

namespace strobe::lab_report {

namespace {

struct Clause {
  const char* number;
  const char* asks;
  const char* section;  ///< key
  const char* where;    ///< in it
};

constexpr Clause kClauses[] = {
    {"7.8.2.1 a", "title", "", "head of the report"},
    {"7.8.2.1 b", "name and address of the laboratory", "identification", "laboratory, address"},
    {"7.8.2.1 c", "place of the laboratory's activities", "identification", "place of the tests"},
    {"7.8.2.1 d", "unique identification on each page, end", "", "foot of each page, end mark"},
    {"7.8.2.1 e", "name and contact of the customer", "identification", "customer"},
    {"7.8.2.1 f", "method", "method", "method, principle"},
    {"7.8.2.1 g", "item: description, identification, condition", "identification", "item tested"},
    {"7.8.2.1 h", "dates of receipt and sampling", "identification", "date of receipt"},
    {"7.8.2.1 i", "dates of the tests", "identification", "dates of the tests"},
    {"7.8.2.1 j", "date of issue", "identification", "date of issue"},
    {"7.8.2.1 k", "sampling plan and method", "identification", "sampling"},
    {"7.8.2.1 l", "results relate only to the items tested", "identification", "statement"},
    {"7.8.2.1 m", "results with units", "results", "tables"},
    {"7.8.2.1 n", "deviations, additions, exclusions", "method", "deviations"},
    {"7.8.2.1 o", "who authorises the report", "identification", "signature"},
    {"7.8.2.1 p", "results of external providers", "", "none: all results are of this session"},
    {"7.8.3.1 a", "test conditions", "identification", "environmental conditions"},
    {"7.8.3.1 b", "statement of conformity", "conformity", "tables"},
    {"7.8.3.1 c", "measurement uncertainty", "results", "U; budgets in their own section"},
    {"7.8.6.1", "decision rule and its risk", "conformity", "decision rule"},
    {"7.8.6.2", "results, specifications and rule of the statement", "conformity", "tables"},
};

std::string place(const Clause& clause, const std::vector<Section>& sections) {
  for (std::size_t i = 0; i < sections.size(); ++i)
    if (sections[i].key == clause.section) return fmt::format("section {}: {}", i + 1, clause.where);
  return clause.where;
}

/// Each once, section by section.
std::vector<std::string> unstated(const std::vector<Section>& sections) {
  std::vector<std::string> out;
  for (std::size_t i = 0; i < sections.size(); ++i) {
    std::vector<std::string> labels;
    const auto look = [&](const std::vector<Fact>& facts) {
      for (const Fact& fact : facts)
        if (!fact.stated && std::find(labels.begin(), labels.end(), fact.label) == labels.end())
          labels.push_back(fact.label);
    };
    for (const Block& block : sections[i].blocks) {
      if (const auto* facts = std::get_if<Facts>(&block)) look(facts->facts);
      if (const auto* signature = std::get_if<Signature>(&block)) look(signature->lines);
    }
    if (!labels.empty()) out.push_back(fmt::format("section {}: {}", i + 1, fmt::join(labels, ", ")));
  }
  return out;
}

}  // namespace

Section clauses(const Content&, const std::vector<Section>& before) {
  Section section{"clauses", "What ISO/IEC 17025:2017, 7.8, asks for", {}};
  Table table{
      "clauses",
      "",
      {{"clause", "clause", "", false}, {"asks", "asks for", "", false}, {"where", "stands in", "", false}},
      {},
      {}};
  for (const Clause& clause : kClauses)
    table.rows.push_back(
        {{text_cell(clause.number), text_cell(clause.asks), text_cell(place(clause, before))}});
  section.blocks.emplace_back(std::move(table));
  std::string words;
  for (const std::string& each : unstated(before)) words += (words.empty() ? "" : "; ") + each;
  section.blocks.emplace_back(
      Paragraph{"not_stated", words.empty() ? "Nothing is left unstated." : "Not stated: " + words + "."});
  return section;
}

}  // namespace strobe::lab_report
