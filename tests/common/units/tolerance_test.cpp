#include "common/units/tolerance.hpp"

#include <cmath>
#include <cstdint>
#include <random>
#include <string>

#include "tests/support/string_from.hpp"

using strobe::parse_tolerance;
using strobe::tolerance_text;

namespace {

void check_value(double expected, const char* text) {
  const auto value = parse_tolerance(text);
  CHECK_TEXT(value.has_value(), text);
  CHECK_TEXT(*value == expected, text);
}

void check_error(const char* expected, const char* text) {
  const auto value = parse_tolerance(text);
  CHECK_TEXT(!value.has_value(), text);
  CHECK_EQUAL(expected, value.error().message);
}

}  // namespace

TEST_GROUP(Tolerance){};

TEST(Tolerance, IsANumberOrAPercentage) {
  check_value(5e-3, "5e-3");
  check_value(5e-3, "0.005");
  check_value(5e-3, "0.5%");
  check_value(5e-3, " 0.5 % ");
  check_value(5e-3, ".5%");
  check_value(5e-3, "5E-1%");
  check_value(1e-6, "1e-4%");
  check_value(1e-10, "1e-08%");
  check_value(1e-3, "1e-3");
  check_value(1.0, "100%");
  check_value(1.0, "1e+0");
}

TEST(Tolerance, APercentageIsTheSameDoubleAsItsHundredth) {
  check_value(0.001, "0.1%");
  check_value(0.0007, "0.07%");
  check_value(0.00033, "0.033%");
}

TEST(Tolerance, RefusesWhatIsNoneAndShowsIt) {
  for (const char* text : {"", "%", "abc", "1,5%", "0x1p-3", "nan", "inf", "1e", "1e-3e", "1e-3 5", "5%%",
                           "+1%", "1e+-3", "1e99999999999", "1.e.", "--1"}) {
    const auto value = parse_tolerance(text);
    CHECK_TEXT(!value, text);
    CHECK_TEXT(
        value.error().message.find("is not a tolerance; write one as 0.5% or 5e-3") != std::string::npos,
        text);
  }
  check_error("'1?2' is not a tolerance; write one as 0.5% or 5e-3", "1\n2");
}

TEST(Tolerance, RefusesWhatIsNotAboveNothingOrAboveAll) {
  check_error("'0' is not a tolerance: it must be above 0", "0");
  check_error("'-0.1%' is not a tolerance: it must be above 0", "-0.1%");
  check_error("'101%' is more than 100%", "101%");
  check_error("'1000' is more than 100%", "1000");
}

TEST(Tolerance, AsksWhetherAPercentSignWasLeftOut) {
  check_error("'5' is more than 100%; did you mean 5%?", "5");
}

TEST(Tolerance, IsShownAsAPercentageInFewDigits) {
  CHECK_EQUAL("0.5%", tolerance_text(5e-3));
  CHECK_EQUAL("0.1%", tolerance_text(1e-3));
  CHECK_EQUAL("5%", tolerance_text(0.05));
  CHECK_EQUAL("12.5%", tolerance_text(0.125));
  CHECK_EQUAL("100%", tolerance_text(1.0));
  CHECK_EQUAL("0.0001%", tolerance_text(1e-6));
  CHECK_EQUAL("1e-10%", tolerance_text(1e-12));
  CHECK_EQUAL("1.25e-6%", tolerance_text(1.25e-8));
}

TEST(Tolerance, ComesBackFromItsTextToTheLastBit) {
  constexpr std::uint64_t kSeed = 20260131;
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> power(-320.0, 0.0);
  for (int i = 0; i < 5000; ++i) {
    const double tolerance = std::pow(10.0, power(random));
    if (!(tolerance > 0.0)) continue;
    const std::string text = tolerance_text(tolerance);
    check_value(tolerance, text.c_str());
  }
}
