#include "host/report/content/conformity.hpp"

#include <array>
#include <charconv>
#include <cmath>

namespace strobe::lab_report {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// International Tennis Federation, court pace classification: up to 29, 30 to 34, 35 to 39, 40 to 44, 45 and more.
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

std::optional<reduction::Quantity> quantity_of(std::string_view text) {
  for (std::size_t i = 0; i < reduction::kQuantityCount; ++i)
    if (reduction::kQuantityNames[i] == text) return static_cast<reduction::Quantity>(i);
  return std::nullopt;
}

std::string all_names() {
  std::string names;
  for (const std::string_view each : reduction::kQuantityNames)
    names += (names.empty() ? "" : ", ") + std::string(each);
  return names;
}

}  // namespace

Result<Limit> parse_limit(std::string_view text) {
  const std::string given = "limit \"" + std::string(text) + "\": ";
  const std::size_t equals = text.find('=');
  const std::size_t dots = text.find("..", equals == text.npos ? 0 : equals);
  if (equals == text.npos || dots == text.npos)
    return fail(given + "must be QUANTITY=LOW..HIGH, as e=0.80..0.86");
  const auto quantity = quantity_of(text.substr(0, equals));
  if (!quantity) return fail(given + "no such quantity; there are " + all_names());
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

std::string_view name(DecisionRule rule) { return rule == DecisionRule::guarded ? "guarded" : "simple"; }

std::string_view words(DecisionRule rule) {
  if (rule == DecisionRule::simple)
    return "Simple acceptance (ILAC-G8:09/2019, 4.2.1; guard band 0): the result conforms where it lies "
           "within the limits, "
           "and else does not. A result at a limit is wrongly accepted or rejected with a probability of 50 "
           "%.";
  return "Guard bands (ILAC-G8:09/2019, 4.2.3; guard band w = U, the expanded uncertainty at 95 %): the "
         "result conforms "
         "where it lies within the limits by U or more, does not conform where it lies beyond one by more "
         "than U, and "
         "else is not decided. Of a limit, a wrong acceptance or rejection has a probability of at most 2.5 "
         "%.";
}

std::string_view words(Conformity conformity) {
  if (conformity == Conformity::conforms) return "conforms";
  return conformity == Conformity::does_not_conform ? "does not conform" : "not decided";
}

Conformity judge(double value, std::optional<double> expanded_uncertainty, const Limit& limit,
                 DecisionRule rule) {
  if (!std::isfinite(value) || !expanded_uncertainty || !std::isfinite(*expanded_uncertainty))
    return Conformity::undecided;
  const double guard = rule == DecisionRule::guarded ? *expanded_uncertainty : 0.0;
  if (value - guard >= limit.low && value + guard <= limit.high) return Conformity::conforms;
  if (value + guard < limit.low || value - guard > limit.high) return Conformity::does_not_conform;
  return Conformity::undecided;
}

const PaceCategory* pace_category(double rating, std::optional<double> expanded_uncertainty,
                                  DecisionRule rule) {
  for (const PaceCategory& category : kPaceCategories) {
    const Limit limit{reduction::Quantity::court_pace, category.low, category.high};
    if (judge(rating, expanded_uncertainty, limit, rule) == Conformity::conforms) return &category;
  }
  return nullptr;
}

}  // namespace strobe::lab_report
