// Statements of conformity with limits, by a decision rule that takes the uncertainty into account. Pure;
// thread-safe. Source: ISO/IEC 17025:2017, 7.8.6; ILAC-G8:09/2019, 4.2; JCGM 106:2012, 8.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <string_view>

#include "common/reduction/readout.hpp"
#include "common/result.hpp"
#include "host/protocol/decision.hpp"

namespace strobe::report {

/// Inclusive; infinite: there is no such limit.
struct Limit {
  reduction::Quantity quantity = reduction::Quantity::e;
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
};

/// "e=0.80..0.86", "court_pace=..34.5": a quantity's name, its least and its largest value; one of them may
/// be left out.
Result<Limit> parse_limit(std::string_view text);

using protocol::DecisionRule;

/// Of rule guarded: with it, a single limit has a guard band as wide as the expanded uncertainty at 95 %.
inline constexpr double kConformityRisk = 0.025;

/// A sentence for a report.
std::string_view sentence(DecisionRule rule);

enum class Conformity { conforms, does_not_conform, undecided };
/// "conforms", "does not conform", "not decided".
std::string_view name(Conformity conformity);

/// As protocol::decide(), of an expanded uncertainty at 95 % with these degrees of freedom (absent:
/// infinitely many). Without an expanded uncertainty nothing is decided.
Conformity judge(double value, std::optional<double> expanded_uncertainty, const Limit& limit,
                 DecisionRule rule, std::optional<double> degrees_of_freedom = {});

/// Categories of court pace: "slow" to "fast", by the rating rounded to a whole number.
struct PaceCategory {
  std::string_view name;
  double low, high;  ///< between which the unrounded rating lies
};
/// The category that the rating and its uncertainty decide for. Returns nullptr if they decide for none.
const PaceCategory* pace_category(double rating, std::optional<double> expanded_uncertainty,
                                  DecisionRule rule, std::optional<double> degrees_of_freedom = {});

}  // namespace strobe::report
