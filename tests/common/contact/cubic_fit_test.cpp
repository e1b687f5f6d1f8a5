#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "common/contact/differentiation/differentiation.hpp"
#include "common/data/csv.hpp"
#include "tests/common/contact/wide_cubic_fit.hpp"
#include "tests/common/physics/thesis_folder.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using contact::CubicFit;
using strobe::testing::thesis_data;

namespace {

struct Columns {
  std::vector<double> t, x, y, rotation;
};

Columns columns_of(const data::ContactSet& set) {
  Columns out;
  for (const auto& row : set.rows) {
    out.t.push_back(row.time_fraction);
    out.x.push_back(row.x_fraction);
    out.y.push_back(row.y_fraction);
    out.rotation.push_back(row.rotation_fraction.value());
  }
  return out;
}

// The columns' condition number is below 1e3 and residuals are small, so QR loses at most some 1e-12.
void check_against_wide(const std::vector<double>& t, const std::vector<double>& y, const std::string& name) {
  const auto fit = contact::fit_cubic(t, y);
  const testing::WideCubicFit wide(t, y);
  for (std::size_t i = 0; i < 4; ++i) {
    const double scale =
        std::abs(static_cast<double>(wide.c[i])) + static_cast<double>(wide.standard_error(i));
    CHECK_TEXT(std::abs(fit->coefficients[i] - static_cast<double>(wide.c[i])) < 1e-12 * scale, name.c_str());
    DOUBLES_EQUAL(1.0, (*fit->standard_errors)[i] / static_cast<double>(wide.standard_error(i)), 1e-11);
  }
  DOUBLES_EQUAL(static_cast<double>(wide.r2), *fit->r_squared, 1e-13);
}

contact::FractionFits fits_as_printed(const std::string& name) {
  return contact::fit_fractions(thesis_data(thesis::Version::as_printed).contact.at(name));
}

double rounded(double value, int decimals) {
  return std::round(value * std::pow(10.0, decimals)) / std::pow(10.0, decimals);
}

}  // namespace

TEST_GROUP(CubicFits){};

TEST(CubicFits, AgreeWithHundredDigitNormalEquationsOnAllSets) {
  for (const auto& [name, set] : thesis_data(thesis::Version::as_printed).contact) {
    const Columns c = columns_of(set);
    check_against_wide(c.t, c.x, name + " x");
    check_against_wide(c.t, c.y, name + " y");
    check_against_wide(c.t, c.rotation, name + " rotation");
  }
}

// Each value of the table is met to its last digit: half a unit of it, and a hair for the decimal's own
// rounding.
TEST(CubicFits, GiveTable11ToTheLastDigit) {
  const std::array<std::string_view, 5> header{"set", "curve", "term", "value", "provenance"};
  const std::string text = strobe::testing::thesis_file("table_11.csv");
  const auto rows = data::parse_csv(text, "table_11.csv", header);
  CHECK(rows.has_value());
  LONGS_EQUAL(45, rows->size());
  for (const data::CsvRow& row : *rows) {
    const auto fits = fits_as_printed(std::string(row.cells[0]));
    const auto& fit = row.cells[1] == "x" ? fits.x : row.cells[1] == "y" ? fits.y : fits.rotation;
    const double got = row.cells[2] == "r2"
                           ? *fit->r_squared
                           : fit->coefficients[static_cast<std::size_t>(row.cells[2][1] - '0')];
    const double want = *data::parse_number(row.cells[3], "table_11.csv", row.line, "value");
    const auto decimals = row.cells[3].size() - row.cells[3].find('.') - 1;
    CHECK_TEXT(
        std::abs(got - want) <= 0.5 * std::pow(10.0, -static_cast<double>(decimals)) + 1e-12,
        std::string(row.cells[0]).append(" ").append(row.cells[1]).append(" ").append(row.cells[2]).c_str());
  }
}

// Table 12 (back -22) is in fractions and derived from the three decimals of Table 11.
TEST(CubicFits, GiveTheDerivativesOfTable12) {
  const auto fits = fits_as_printed("back_22");
  const double y3 = rounded(fits.y->coefficients[3], 3);
  const double x3 = rounded(fits.x->coefficients[3], 3);
  DOUBLES_EQUAL(-1.647, 3.0 * y3, 1e-12);
  DOUBLES_EQUAL(3.294, -6.0 * y3, 1e-12);
  DOUBLES_EQUAL(0.384, 3.0 * x3, 1e-12);
  DOUBLES_EQUAL(0.768, 6.0 * x3, 1e-12);
  DOUBLES_EQUAL(-17.48, fits.rotation->slope(0.0), 0.005);
}

// Half of the last digit of 8.04 is 0.005; the dwell distance of 6.29 cm is good to a thousandth of that.
TEST(CubicFits, PredictTheLiftOffSpeedOfTable13) {
  const contact::ContactScale scale{.dwell_time_s = 5.2e-3, .dwell_distance_m = 0.0629};
  const auto motion = contact::derive(fits_as_printed("zero_23"), scale, 1.0);
  DOUBLES_EQUAL(8.04, motion.vx_mps->value, 0.011);
}

// The total rotation is not printed. Whatever it was, one value must give both ends of the backspin row:
// scaled so that touchdown reads +580 rad/s (to a unit), lift-off reads -15. The zero row's +129.9 has the
// sign of a ball that turned clockwise in total, as its -313 rad/s at lift-off demands.
TEST(CubicFits, PredictTheSpinsOfTable13WithOneTotalRotation) {
  const auto back = fits_as_printed("back_22");
  const contact::ContactScale unit{
      .dwell_time_s = 5.1241e-3, .dwell_distance_m = 1.0, .total_rotation_rad = 1.0};
  const double total_rad = 580.0 / contact::derive(back, unit, 0.0).omega_radps->value;
  contact::ContactScale scale = unit;
  scale.total_rotation_rad = total_rad;
  DOUBLES_EQUAL(-15.0, contact::derive(back, scale, 1.0).omega_radps->value, 0.1);

  const auto zero = fits_as_printed("zero_23");
  const contact::ContactScale zero_unit{
      .dwell_time_s = 5.1996e-3, .dwell_distance_m = 1.0, .total_rotation_rad = 1.0};
  const double zero_total_rad = 129.9 / contact::derive(zero, zero_unit, 0.0).omega_radps->value;
  CHECK(zero_total_rad < 0.0);
  // Between no spin and the measured lift-off spin throughout.
  CHECK(zero_total_rad > -313.2 * 5.1996e-3);
}

TEST(CubicFits, DerivativesAreThoseOfTheirOwnCurve) {
  const std::vector<double> t5{-1.0, -0.2, 0.4, 1.1, 2.0};
  std::vector<double> y5;
  for (const double t : t5) y5.push_back(0.3 + t * (-1.2 + t * (2.5 - 0.7 * t)));
  const CubicFit fit = contact::fit_cubic(t5, y5).value();
  // Central differences of a cubic: the slope's error is c3·h², the curvature's is rounding, 4·eps·|f|/h².
  const double h = 1e-3;
  for (const double t : {0.0, 0.3, 1.0}) {
    DOUBLES_EQUAL((fit.value(t + h) - fit.value(t - h)) / (2 * h), fit.slope(t), 1.1 * 0.7 * h * h);
    DOUBLES_EQUAL((fit.value(t + h) - 2 * fit.value(t) + fit.value(t - h)) / (h * h), fit.curvature(t), 1e-8);
  }
}

TEST(CubicFits, FourRowsAreMetExactlyAndHaveNoStandardErrors) {
  const std::vector<double> t{0.0, 0.25, 0.5, 1.0};
  const std::vector<double> y{1.0, 0.0, -2.0, 4.0};
  const auto fit = contact::fit_cubic(t, y);
  for (std::size_t i = 0; i < 4; ++i) DOUBLES_EQUAL(y[i], fit->value(t[i]), 1e-13);
  CHECK_FALSE(fit->standard_errors.has_value());
}

TEST(CubicFits, RefuseWhatDoesNotDetermineThem) {
  const std::vector<double> three{0.0, 0.5, 1.0};
  const std::vector<double> repeated{0.0, 0.5, 0.5, 0.5, 1.0};
  const std::vector<double> five{1.0, 2.0, 3.0, 4.0, 5.0};
  const std::vector<double> nan{0.0, 0.5, 0.7, std::numeric_limits<double>::quiet_NaN(), 1.0};
  CHECK_EQUAL("a cubic fit needs at least four rows", contact::fit_cubic(three, three).error().message);
  CHECK_EQUAL("a cubic fit needs four different times", contact::fit_cubic(repeated, five).error().message);
  CHECK_EQUAL("a cubic fit needs as many times as values", contact::fit_cubic(five, three).error().message);
  CHECK_EQUAL("a cubic fit needs finite numbers", contact::fit_cubic(nan, five).error().message);
}

TEST(CubicFits, OfAConstantHaveNoRSquared) {
  const std::vector<double> t{0.0, 0.2, 0.5, 0.7, 1.0};
  const std::vector<double> y(5, 0.25);
  CHECK_FALSE(contact::fit_cubic(t, y)->r_squared.has_value());
}
