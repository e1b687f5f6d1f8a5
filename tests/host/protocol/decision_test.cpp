// Decisions against probabilities that are integrated here.
#include <cmath>
#include <limits>

#include "host/protocol/decision.hpp"
#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::protocol;

namespace {

constexpr double kFree = std::numeric_limits<double>::infinity();

/// Of Student's t with that many degrees of freedom, by Simpson's rule; beyond `reach` there is less than 1e-9 for
/// seven and more.
double t_between(double low, double high, double nu) {
  const double norm = std::tgamma(0.5 * (nu + 1.0)) / (std::sqrt(nu * std::acos(-1.0)) * std::tgamma(0.5 * nu));
  const auto density = [&](double t) { return norm * std::pow(1.0 + t * t / nu, -0.5 * (nu + 1.0)); };
  constexpr int kSteps = 200000;
  const double h = (high - low) / kSteps;
  double sum = density(low) + density(high);
  for (int i = 1; i < kSteps; ++i) sum += density(low + i * h) * (i % 2 == 1 ? 4.0 : 2.0);
  return sum * h / 3.0;
}

}  // namespace

TEST_GROUP(ProtocolDecision){};

// Simpson's rule with 200,000 steps over 400 sds is good to 1e-10; what lies beyond 200 sds of seven degrees of freedom is
// below 1e-13.
TEST(ProtocolDecision, KnowsTheProbabilityOfConformance) {
  for (const double nu : {7.0, 7.5, 30.0})
    for (const double value : {-1.0, 0.0, 0.3, 1.0, 2.5}) {
      const double sd = 0.4, low = 0.0, high = 1.0;
      const auto t = [&](double limit) { return (limit - value) / sd; };
      DOUBLES_EQUAL(t_between(t(low), t(high), nu), probability_within({value, sd, nu}, {low, high}), 1e-9);
      DOUBLES_EQUAL(t_between(-200.0, t(high), nu), probability_within({value, sd, nu}, {-kFree, high}), 1e-9);
      DOUBLES_EQUAL(t_between(t(low), 200.0, nu), probability_within({value, sd, nu}, {low, kFree}), 1e-9);
    }
}

// Normal distribution: 5 % lie beyond 1.644854 sds.
TEST(ProtocolDecision, GuardedDecidesWhereTheRiskAllowsIt) {
  const Interval at_most{-kFree, 10.0};
  const auto of = [&](double value) { return decide({value, 1.0}, at_most, DecisionRule::guarded, 0.05); };
  CHECK_TRUE(of(10.0 - 1.6449).decision == Decision::pass);
  CHECK_TRUE(of(10.0 - 1.6448).decision == Decision::inconclusive);
  CHECK_TRUE(of(10.0 + 1.6448).decision == Decision::inconclusive);
  CHECK_TRUE(of(10.0 + 1.6449).decision == Decision::fail);
  DOUBLES_EQUAL(0.05, of(10.0 - 1.644854).risk, 1e-6);
  DOUBLES_EQUAL(0.5, of(10.0).risk, 1e-12);
}

TEST(ProtocolDecision, SimpleDecidesByTheValueAndTellsTheRisk) {
  const auto decided = decide({10.1, 1.0}, {-kFree, 10.0}, DecisionRule::simple, 0.05);
  CHECK_TRUE(decided.decision == Decision::fail);
  DOUBLES_EQUAL(0.5 * std::erfc(0.1 / std::sqrt(2.0)), decided.risk, 1e-12);
}

TEST(ProtocolDecision, AnExactNumberHasNoRisk) {
  const auto decided = decide({10.0, 0.0}, {-kFree, 10.0}, DecisionRule::guarded, 0.05);
  CHECK_TRUE(decided.decision == Decision::pass);
  DOUBLES_EQUAL(0.0, decided.risk, 0.0);
}

// In the middle of limits that are a tenth of an sd apart.
TEST(ProtocolDecision, WhatIsHardlyKnownDoesNotFail) {
  CHECK_TRUE(decide({0.05, 1.0}, {0.0, 0.1}, DecisionRule::guarded, 0.05).decision == Decision::inconclusive);
}
