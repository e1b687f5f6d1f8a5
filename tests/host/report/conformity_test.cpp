// Limits as they are asked for, and what is decided of a result near one.
#include <cmath>

#include "host/report/content/conformity.hpp"
#include "tests/support/error_of.hpp"
#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::lab_report;
using strobe::reduction::Quantity;

namespace {

constexpr Limit kLimit{Quantity::e, 0.80, 0.90};

std::string judged(double value, std::optional<double> u, DecisionRule rule) {
  return std::string(words(judge(value, u, kLimit, rule)));
}

std::string refused(const char* text) { return strobe::testing::error_of(parse_limit(text)); }

}  // namespace

TEST_GROUP(Conformity){};

TEST(Conformity, GuardBandsAreAsWideAsTheExpandedUncertainty) {
  CHECK_EQUAL(std::string("conforms"), judged(0.85, 0.04, DecisionRule::guarded));
  CHECK_EQUAL(std::string("conforms"), judged(0.8201, 0.02, DecisionRule::guarded));
  CHECK_EQUAL(std::string("not decided"), judged(0.82, 0.021, DecisionRule::guarded));
  CHECK_EQUAL(std::string("not decided"), judged(0.79, 0.02, DecisionRule::guarded));
  CHECK_EQUAL(std::string("does not conform"), judged(0.79, 0.005, DecisionRule::guarded));
  CHECK_EQUAL(std::string("does not conform"), judged(0.93, 0.02, DecisionRule::guarded));
  CHECK_EQUAL(std::string("not decided"), judged(0.85, 0.2, DecisionRule::guarded));  // wider than the limits
}

TEST(Conformity, SimpleAcceptanceTakesTheLimitsThemselves) {
  CHECK_EQUAL(std::string("conforms"), judged(0.80, 0.05, DecisionRule::simple));
  CHECK_EQUAL(std::string("does not conform"), judged(0.799, 0.05, DecisionRule::simple));
}

TEST(Conformity, WithoutAnUncertaintyNothingIsDecided) {
  for (const DecisionRule rule : {DecisionRule::guarded, DecisionRule::simple}) {
    CHECK_EQUAL(std::string("not decided"), judged(0.85, std::nullopt, rule));
    CHECK_EQUAL(std::string("not decided"), judged(NAN, 0.01, rule));
  }
}

TEST(Conformity, LimitsAreReadOrNamedAsWrong) {
  const auto limit = parse_limit("e=0.80..0.90");
  CHECK(limit && limit->quantity == Quantity::e);
  DOUBLES_EQUAL(0.80, limit->low, 0.0);
  DOUBLES_EQUAL(0.90, limit->high, 0.0);
  CHECK(std::isinf(parse_limit("theta_in_deg=..-15")->low));
  DOUBLES_EQUAL(-17.5, parse_limit("theta_in_deg=-17.5..-15")->low, 0.0);
  CHECK(std::isinf(parse_limit("court_pace=30..")->high));
  STRCMP_CONTAINS("must be QUANTITY=LOW..HIGH", refused("e").c_str());
  STRCMP_CONTAINS("must be QUANTITY=LOW..HIGH", refused("e=1").c_str());
  STRCMP_CONTAINS("no such quantity; there are theta_in_deg", refused("speed=1..2").c_str());
  STRCMP_CONTAINS("least or a largest", refused("e=..").c_str());
  STRCMP_CONTAINS("\"nan\" is not a number", refused("e=nan..1").c_str());
  STRCMP_CONTAINS("\"x\" is not a number", refused("e=0..x").c_str());
  STRCMP_CONTAINS("above the largest", refused("e=2..1").c_str());
}

TEST(Conformity, CourtPaceHasACategoryWhereItsIntervalLiesInOne) {
  CHECK_EQUAL(std::string("medium"), std::string(pace_category(37.0, 2.0, DecisionRule::guarded)->name));
  POINTERS_EQUAL(nullptr, pace_category(39.0, 2.0, DecisionRule::guarded));
  CHECK_EQUAL(std::string("medium"), std::string(pace_category(39.0, 2.0, DecisionRule::simple)->name));
  CHECK_EQUAL(std::string("slow"), std::string(pace_category(-5.0, 2.0, DecisionRule::guarded)->name));
  CHECK_EQUAL(std::string("fast"), std::string(pace_category(60.0, 2.0, DecisionRule::guarded)->name));
  POINTERS_EQUAL(nullptr, pace_category(37.0, std::nullopt, DecisionRule::guarded));
}
