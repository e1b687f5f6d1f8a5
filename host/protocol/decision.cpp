#include "host/protocol/decision.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/statistics/distributions.hpp"

namespace strobe::protocol {
namespace {

/// That the true value is above `limit`.
double probability_above(const Measured& m, double limit) {
  const double t = (limit - m.value) / m.sd;
  const double tail = 0.5 * statistics::student_t_tail(std::abs(t), m.degrees_of_freedom);
  return t > 0.0 ? tail : 1.0 - tail;
}

}  // namespace

std::string words(const Interval& i) {
  if (std::isinf(i.low)) return fmt::format("at most {:.6g}", i.high);
  if (std::isinf(i.high)) return fmt::format("at least {:.6g}", i.low);
  return fmt::format("{:.6g} to {:.6g}", i.low, i.high);
}

std::string percent(double probability) {
  constexpr double kMin = 1e-4;
  if (probability == 0.0 || probability == 1.0) return probability == 0.0 ? "0 %" : "100 %";
  if (probability < kMin) return "less than 0.01 %";
  if (probability > 1.0 - kMin) return "more than 99.99 %";
  return fmt::format("{:.3g} %", 100.0 * probability);
}

double probability_within(const Measured& m, const Interval& limits) {
  if (!(m.sd > 0.0)) return m.value >= limits.low && m.value <= limits.high ? 1.0 : 0.0;
  const double above_low = std::isinf(limits.low) ? 1.0 : probability_above(m, limits.low);
  const double above_high = std::isinf(limits.high) ? 0.0 : probability_above(m, limits.high);
  return std::max(0.0, above_low - above_high);
}

Decided decide(const Measured& measured, const Interval& limits, DecisionRule rule, double risk) {
  Decided decided{.probability = probability_within(measured, limits)};
  const double within = decided.probability;
  const bool inside = measured.value >= limits.low && measured.value <= limits.high;
  if (rule == DecisionRule::simple)
    decided.decision = inside ? Decision::pass : Decision::fail;
  else if (within >= 1.0 - risk)
    decided.decision = Decision::pass;
  else if (!inside && within <= risk)  // inside, it is small of what is not known at all
    decided.decision = Decision::fail;
  decided.risk = decided.decision == Decision::pass   ? 1.0 - within
                 : decided.decision == Decision::fail ? within
                                                      : std::min(within, 1.0 - within);
  return decided;
}

}  // namespace strobe::protocol
