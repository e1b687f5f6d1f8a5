#include "host/report/conformity.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <charconv>
#include <cmath>

#include "common/reduction/uncertainty.hpp"
#include "common/statistics/distributions.hpp"
#include "host/report/sections.hpp"

namespace strobe::report {

namespace {

using reduction::Quantity;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// International Tennis Federation, court pace classification: up to 29, 30 to 34, 35 to 39, 40 to 44, 45 and
/// more.
constexpr std::array<PaceCategory, 5> kPaceCategories{{{"slow", -kInfinity, 29.5},
                                                       {"medium-slow", 29.5, 34.5},
                                                       {"medium", 34.5, 39.5},
                                                       {"medium-fast", 39.5, 44.5},
                                                       {"fast", 44.5, kInfinity}}};

std::optional<double> finite_number(std::string_view text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::optional<Quantity> quantity_of(std::string_view text) {
  const auto found = std::ranges::find(reduction::kQuantityNames, text);
  if (found == reduction::kQuantityNames.end()) return std::nullopt;
  return static_cast<Quantity>(found - reduction::kQuantityNames.begin());
}

std::string range_of(const Limit& limit) {
  if (std::isinf(limit.low)) return fmt::format("at most {}", limit.high);
  if (std::isinf(limit.high)) return fmt::format("at least {}", limit.low);
  return fmt::format("{} to {}", limit.low, limit.high);
}

Row limit_row(const ConditionGroup& group, const Limit& limit, DecisionRule rule) {
  const host::QuantitySummary& s = group.of(limit.quantity);
  const auto verdict = s.n == 0 ? std::string_view("not decided: no result")
                       : !group.mixed.empty()
                           ? std::string_view("not decided: a mean over what differs")
                           : name(judge(s.mean, s.expanded_uncertainty, limit, rule, s.degrees_of_freedom));
  const host::QuantityLabel& label = label_of(limit.quantity);
  return {
      {group.label, label.words, range_of(limit), label.unit, expanded_cell(s), count_cell(s.n), verdict}};
}

Table limits_table(const Content& content) {
  Table table{.key = "limits",
              .title = "Results against the limits that were asked for",
              .columns = {text_column("condition"), text_column("quantity"), text_column("limits"),
                          text_column("unit"), number_column("result", "mean ± U"), number_column("n"),
                          text_column("conformity")},
              .notes = {"Each statement is about the mean of the condition's shots that count."}};
  for (const Limit& limit : content.input.limits)
    for (const ConditionGroup& group : content.conditions)
      table.rows.push_back(limit_row(group, limit, content.input.rule));
  return table;
}

Row pace_row(const ConditionGroup& group, DecisionRule rule) {
  const auto& s = group.court_pace->quantities[static_cast<std::size_t>(Quantity::court_pace)];
  const PaceCategory* category =
      s.n == 0 ? nullptr : pace_category(s.mean, s.expanded_uncertainty, rule, s.degrees_of_freedom);
  return {{group.label, count_cell(s.n), expanded_cell(s), category ? category->name : "not decided"}};
}

Table pace_table(const Content& content) {
  Table table{.key = "court_pace",
              .title = "Court pace by ITF CS 01/02",
              .columns = {text_column("condition"), number_column("n", "conforming shots"),
                          number_column("rating", "rating ± U"), text_column("category")},
              .notes = {"Shots that meet the method's limits alone: 30 ± 2 m/s, 16 ± 2 degrees, at most 3 "
                        "revolutions a second. Number and places of the positions tested, and the ball's "
                        "selection, are not checked here.",
                        "Categories by the rating rounded to a whole number: slow up to 29, medium-slow 30 "
                        "to 34, medium 35 to 39, medium-fast 40 to 44, fast 45 and more."}};
  for (const ConditionGroup& group : content.conditions)
    if (group.court_pace) table.rows.push_back(pace_row(group, content.input.rule));
  return table;
}

}  // namespace

Result<Limit> parse_limit(std::string_view text) {
  const std::string given = "limit \"" + std::string(text) + "\": ";
  const std::size_t equals = text.find('=');
  const std::size_t dots = text.find("..", equals == text.npos ? 0 : equals);
  if (equals == text.npos || dots == text.npos)
    return fail(given + "must be QUANTITY=LOW..HIGH, as e=0.80..0.86");
  const auto quantity = quantity_of(text.substr(0, equals));
  if (!quantity)
    return fail(given + "no such quantity; there are " +
                fmt::format("{}", fmt::join(reduction::kQuantityNames, ", ")));
  Limit limit{.quantity = *quantity};
  const std::string_view low = text.substr(equals + 1, dots - equals - 1), high = text.substr(dots + 2);
  if (low.empty() && high.empty()) return fail(given + "needs a least or a largest value");
  for (const auto& [words, value] : {std::pair{low, &limit.low}, {high, &limit.high}}) {
    if (words.empty()) continue;
    const auto number = finite_number(words);
    if (!number) return fail(given + "\"" + std::string(words) + "\" is not a number");
    *value = *number;
  }
  if (limit.low > limit.high) return fail(given + "the least value is above the largest");
  return limit;
}

std::string_view sentence(DecisionRule rule) {
  if (rule == DecisionRule::simple)
    return "Simple acceptance (ILAC-G8:09/2019, 4.2.1; guard band 0): the result conforms where it lies "
           "within the limits, and else does not. A result at a limit is wrongly accepted or rejected with a "
           "probability of 50 "
           "%.";
  return "Guard bands (JCGM 106:2012, 8.3; ILAC-G8:09/2019, 4.2.3): the result conforms where it lies within "
         "the "
         "limits with a probability of 97.5 % or more, does not conform where it lies beyond them and that "
         "probability is 2.5 % or less, and else is not decided. Of one limit the guard band is as wide as "
         "U, the "
         "expanded uncertainty at 95 %. A wrong acceptance or rejection has a probability of at most 2.5 "
         "%.";
}

std::string_view name(Conformity conformity) {
  if (conformity == Conformity::conforms) return "conforms";
  return conformity == Conformity::does_not_conform ? "does not conform" : "not decided";
}

Conformity judge(double value, std::optional<double> expanded_uncertainty, const Limit& limit,
                 DecisionRule rule, std::optional<double> degrees_of_freedom) {
  assert(limit.low <= limit.high);
  if (!std::isfinite(value) || !expanded_uncertainty || !std::isfinite(*expanded_uncertainty))
    return Conformity::undecided;
  protocol::Measured measured{value};
  measured.degrees_of_freedom = degrees_of_freedom.value_or(measured.degrees_of_freedom);
  measured.sd = *expanded_uncertainty /
                statistics::student_t_half_width(reduction::kExpandedLevel, measured.degrees_of_freedom);
  const protocol::Decided decided =
      protocol::decide(measured, {limit.low, limit.high}, rule, kConformityRisk);
  if (decided.decision == protocol::Decision::pass) return Conformity::conforms;
  return decided.decision == protocol::Decision::fail ? Conformity::does_not_conform : Conformity::undecided;
}

const PaceCategory* pace_category(double rating, std::optional<double> expanded_uncertainty,
                                  DecisionRule rule, std::optional<double> degrees_of_freedom) {
  for (const PaceCategory& category : kPaceCategories) {
    const Limit limit{Quantity::court_pace, category.low, category.high};
    if (judge(rating, expanded_uncertainty, limit, rule, degrees_of_freedom) == Conformity::conforms)
      return &category;
  }
  return nullptr;
}

Section conformity(const Content& content) {
  Section section{"conformity", "Statement of conformity"};
  Table pace = pace_table(content);
  if (content.input.limits.empty() && pace.rows.empty()) {
    section.blocks.emplace_back(Paragraph{"none",
                                          "No limits were asked for, and no shot meets the limits of the "
                                          "court pace test: no statement of conformity is made."});
    return section;
  }
  section.blocks.emplace_back(
      Paragraph{"decision_rule", "Decision rule. " + std::string(sentence(content.input.rule))});
  if (!content.input.limits.empty()) section.blocks.emplace_back(limits_table(content));
  if (!pace.rows.empty()) section.blocks.emplace_back(std::move(pace));
  return section;
}

}  // namespace strobe::report
