// Statements of conformity.
#include <fmt/format.h>

#include <cmath>

#include "host/report/sections/parts.hpp"
#include "host/report/sections/sections.hpp"
#include "host/text/text.hpp"

namespace strobe::lab_report {

namespace {

using reduction::Quantity;

std::string words(const Limit& limit) {
  if (std::isinf(limit.low)) return fmt::format("at most {}", limit.high);
  if (std::isinf(limit.high)) return fmt::format("at least {}", limit.low);
  return fmt::format("{} to {}", limit.low, limit.high);
}

Row limit_row(const ConditionGroup& group, const Limit& limit, DecisionRule rule) {
  const host::QuantitySummary& s = group.of(limit.quantity);
  const std::string verdict = s.n == 0
                                  ? "not decided: no result"
                                  : std::string(words(judge(s.mean, s.expanded_uncertainty, limit, rule)));
  const host::QuantityLabel& label = label_of(limit.quantity);
  return {{text_cell(group.label), text_cell(std::string(label.words)), text_cell(words(limit)),
           text_cell(std::string(label.unit)), expanded_cell(s), count_cell(s.n), text_cell(verdict)}};
}

Table limits_table(const Content& content) {
  Table table{"limits",
              "Results against the limits that were asked for",
              {{"condition", "condition", "", false},
               {"quantity", "quantity", "", false},
               {"limits", "limits", "", false},
               {"unit", "unit", "", false},
               {"result", "mean ± U", ""},
               {"n", "n", ""},
               {"conformity", "conformity", "", false}},
              {},
              {"Each statement is about the mean of the condition's shots that count."}};
  for (const Limit& limit : content.input.limits)
    for (const ConditionGroup& group : content.conditions)
      table.rows.push_back(limit_row(group, limit, content.input.rule));
  return table;
}

Row pace_row(const ConditionGroup& group, DecisionRule rule) {
  const auto& s = group.court_pace->quantities[static_cast<std::size_t>(Quantity::court_pace)];
  const PaceCategory* category = s.n == 0 ? nullptr : pace_category(s.mean, s.expanded_uncertainty, rule);
  return {{text_cell(group.label), count_cell(s.n), expanded_cell(s),
           text_cell(category ? std::string(category->name) : "not decided")}};
}

Table pace_table(const Content& content) {
  Table table{"court_pace",
              "Court pace by ITF CS 01/02",
              {{"condition", "condition", "", false},
               {"n", "conforming shots", ""},
               {"rating", "rating ± U", ""},
               {"category", "category", "", false}},
              {},
              {"Shots that meet the method's limits alone: 30 ± 2 m/s, 16 ± 2 degrees, at most 3 revolutions "
               "a second. "
               "Number and places of the positions tested, and the ball's selection, are not checked here.",
               "Categories by the rating rounded to a whole number: slow up to 29, medium-slow 30 to 34, "
               "medium 35 to 39, "
               "medium-fast 40 to 44, fast 45 and more."}};
  for (const ConditionGroup& group : content.conditions)
    if (group.court_pace) table.rows.push_back(pace_row(group, content.input.rule));
  return table;
}

}  // namespace

Section conformity(const Content& content) {
  Section section{"conformity", "Statement of conformity", {}};
  Table pace = pace_table(content);
  if (content.input.limits.empty() && pace.rows.empty()) {
    section.blocks.emplace_back(Paragraph{
        "none",
        "No limits were asked for, and no shot meets the limits of the court pace test: no statement of "
        "conformity is made."});
    return section;
  }
  section.blocks.emplace_back(
      Paragraph{"decision_rule", "Decision rule. " + std::string(words(content.input.rule))});
  if (!content.input.limits.empty()) section.blocks.emplace_back(limits_table(content));
  if (!pace.rows.empty()) section.blocks.emplace_back(std::move(pace));
  return section;
}

}  // namespace strobe::lab_report
