// Decisions about a limit from a value and its uncertainty: the probability that the true value lies within,
// and what a rule makes of it. Pure; thread-safe. Source: JCGM 106:2012, 7 (with no more
// known of the value beforehand than its measurement says) and 8.3; of few degrees of freedom Student's t
// (its 7.2.2, 7.3).
#pragma once

#include <limits>
#include <string>

namespace strobe::protocol {

/// Inclusive; infinite: there is no such limit.
struct Interval {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
};

/// "28 to 32", "at most 0.05".
std::string words(const Interval& interval);

/// "97.2 %"; near 0 and 1 "less than 0.01 %", "more than 99.99 %".
std::string percent(double probability);

/// What a measurement says of a number: (true - value) / sd is Student's t.
struct Measured {
  double value = 0.0;
  double sd = 0.0;                                                      ///< >= 0
  double degrees_of_freedom = std::numeric_limits<double>::infinity();  ///< > 0
};

/// With sd 0: 1 or 0.
double probability_within(const Measured& measured, const Interval& limits);

enum class DecisionRule {
  guarded,  ///< pass and fail (of a value beyond) only where the probability to be wrong is at most `risk`
  simple,   ///< by the value alone; the risk is told
};

enum class Decision { pass, fail, inconclusive };

struct Decided {
  Decision decision = Decision::inconclusive;
  double probability = 0.0;  ///< that the true value lies within
  double risk = 0.0;         ///< that the decision is wrong; of an inconclusive one the smaller of both
};

/// risk: 0 to 0.5, of rule guarded.
Decided decide(const Measured& measured, const Interval& limits, DecisionRule rule, double risk);

}  // namespace strobe::protocol
