// What the uncertainties are made of.
#include <fmt/format.h>

#include <algorithm>

#include "host/report/sections/parts.hpp"
#include "host/report/sections/sections.hpp"

namespace strobe::lab_report {

namespace {

using host::BudgetLine;
using host::EvaluationType;
using reduction::Quantity;

std::vector<Quantity> with_budget(const ConditionGroup& group, const std::vector<Quantity>& quantities) {
  std::vector<Quantity> out;
  for (const Quantity q : quantities)
    if (!group.of(q).budget.empty()) out.push_back(q);
  return out;
}

/// Sources down, quantities across: the effect of each on the mean.
Table overview(const ConditionGroup& group, const std::vector<Quantity>& quantities) {
  Table table{"overview_" + group.key,
              "Effects on the means, one standard deviation: " + group.label,
              {{"source", "source", "", false}},
              {},
              {}};
  std::vector<std::string> sources;
  for (const Quantity q : quantities) {
    const host::QuantityLabel& label = label_of(q);
    table.columns.push_back(
        {std::string(reduction::name(q)), std::string(label.words), std::string(label.unit)});
    for (const BudgetLine& line : group.of(q).budget)
      if (std::find(sources.begin(), sources.end(), line.source) == sources.end())
        sources.push_back(line.source);
  }
  for (const std::string& source : sources) {
    Row row{{text_cell(source)}};
    for (const Quantity q : quantities) {
      const auto& budget = group.of(q).budget;
      const auto line = std::find_if(budget.begin(), budget.end(),
                                     [&](const BudgetLine& each) { return each.source == source; });
      row.cells.push_back(line == budget.end() ? Cell{"-", {}} : sd_cell(line->effect));
    }
    table.rows.push_back(std::move(row));
  }
  Row total{{text_cell("combined")}, true, false};
  for (const Quantity q : quantities) total.cells.push_back(sd_cell(group.of(q).total_sd));
  table.rows.push_back(std::move(total));
  return table;
}

void add_lines(Table& table, Quantity q, const host::QuantitySummary& s) {
  bool first = true;
  for (const BudgetLine& line : s.budget) {
    const Cell freedom = line.degrees_of_freedom && *line.degrees_of_freedom < 1e4
                             ? Cell{fmt::format("{:.1f}", *line.degrees_of_freedom), line.degrees_of_freedom}
                             : Cell{"∞", {}};
    const Cell sensitivity =
        line.sensitivity ? Cell{fmt::format("{:.3g}", *line.sensitivity), line.sensitivity} : Cell{"-", {}};
    const Cell input =
        line.input_sd > 0.0 ? Cell{fmt::format("{:.3g}", line.input_sd), line.input_sd} : Cell{"-", {}};
    table.rows.push_back(
        {{text_cell(first ? axis_name(q) : ""), text_cell(line.source),
          text_cell(line.type == EvaluationType::a ? "A" : "B"), text_cell(line.shared ? "yes" : "no"), input,
          text_cell(line.input_unit), sensitivity, sd_cell(line.effect),
          Cell{fmt::format("{:.1f} %", 100.0 * line.share), line.share}, freedom},
         first,
         false});
    first = false;
  }
}

Table detailed(const ConditionGroup& group, const std::vector<Quantity>& quantities) {
  Table table{"budget_" + group.key,
              "Budget of each quantity: " + group.label,
              {{"quantity", "quantity", "", false},
               {"source", "source", "", false},
               {"type", "type", "", false},
               {"shared", "shared", "", false},
               {"input_sd", "sd of the source", ""},
               {"input_unit", "its unit", "", false},
               {"sensitivity", "sensitivity", ""},
               {"effect", "effect", "sd"},
               {"share", "share of variance", ""},
               {"degrees_of_freedom", "degrees of freedom", ""}},
              {},
              {}};
  for (const Quantity q : quantities) add_lines(table, q, group.of(q));
  return table;
}

}  // namespace

Section budgets(const Content& content) {
  Section section{"budgets", "Uncertainty budgets", {}};
  const bool details = content.input.all || content.conditions.size() == 1;
  for (const ConditionGroup& group : content.conditions) {
    const auto quantities = with_budget(group, quantities_of(content.input));
    if (quantities.empty()) continue;
    section.blocks.emplace_back(overview(group, quantities));
    if (details) section.blocks.emplace_back(detailed(group, quantities));
  }
  if (section.blocks.empty()) {
    section.blocks.emplace_back(
        Paragraph{"none", "No shot counts: there is nothing to state an uncertainty of."});
  } else {
    section.blocks.insert(
        section.blocks.begin(),
        Paragraph{"meaning",
                  "Type A: evaluated from scatter; type B: by other means. Shared: the same for all shots "
                  "with this rig, ball and calibration, so that more shots do not make it smaller."});
  }
  return section;
}

}  // namespace strobe::lab_report
