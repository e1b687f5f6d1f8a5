#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "common/contact/condition_inputs.hpp"
#include "common/contact/differentiation.hpp"
#include "common/data/csv.hpp"
#include "tests/common/contact/wide_cubic_fit.hpp"
#include "tests/common/physics/thesis_folder.hpp"
#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>

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

// Eighths, whose powers are exact: what is left is the fit's rounding, whatever the degrees of freedom.
TEST(CubicFits, OfValuesOnACubicHaveNoStandardErrors) {
  std::vector<double> t, y;
  for (int i = 0; i <= 8; ++i) {
    t.push_back(i / 8.0);
    y.push_back(0.25 + t.back() - 3.0 * t.back() * t.back() + 2.0 * std::pow(t.back(), 3));
  }
  const auto fit = contact::fit_cubic(t, y);
  DOUBLES_EQUAL(2.0, fit->coefficients[3], 1e-12);
  CHECK_FALSE(fit->standard_errors.has_value());
  CHECK_FALSE(contact::error_growth(*fit).has_value());
  y[3] += 1e-9;
  CHECK(contact::fit_cubic(t, y)->standard_errors.has_value());
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

using testing::thesis_data;

TEST_GROUP(Differentiation){};

// Times `width` apart around .7: the columns 1, t, t², t³ have condition numbers of 1e3 to beyond 1e12. What
// is fitted, its derivatives within the images and their sds keep nearly all digits. The coefficients about t
// = 0, far outside of the images, are what the condition number makes uncertain: they stay within it, and so
// within a small share of their own standard errors.
TEST(Differentiation, KeepsItsDigitsAtConditionNumbersUpToTenToTheTwelve) {
  double largest = 0.0, worst_value = 0.0, worst_sd = 0.0, worst_coefficient = 0.0;
  for (const double width : {0.3, 1e-1, 1e-2, 1e-3, 3e-4, 1e-4}) {
    std::vector<double> t, y;
    for (int i = 0; i < 12; ++i) {
      const double u = (i * i - 60.0) / 60.0;
      t.push_back(0.7 + width * u);
      y.push_back(1.0 + u * (0.5 + u * (-0.3 + 0.2 * u)) + 1e-3 * ((i * 7) % 5 - 2.0));
    }
    const auto fit = contact::fit_cubic(t, y);
    CHECK(fit.has_value());
    largest = std::max(largest, fit->condition.monomial);
    const testing::WideCubicFit wide(t, y);
    for (const double at : {t.front(), t[5], t.back()}) {
      for (int order = 0; order < 3; ++order) {
        const auto got = fit->derivative_with_sd(at, order);
        const auto sd = static_cast<double>(wide.sd(at, order));
        const double scale = std::pow(width, -order);
        worst_value =
            std::max(worst_value, static_cast<double>(abs(got.value - wide.derivative(at, order))) / scale);
        worst_sd = std::max(worst_sd, std::abs(got.sd / sd - 1.0));
      }
    }
    for (std::size_t k = 0; k < 4; ++k) {
      const auto error = static_cast<double>(abs(fit->coefficients[k] - wide.c[k]));
      worst_coefficient = std::max(worst_coefficient, error / (*fit->standard_errors)[k]);
    }
  }
  std::printf("cubic: condition up to %.2g, worst value %.2g, sd %.2g, coefficient over its sd %.2g\n",
              largest, worst_value, worst_sd, worst_coefficient);
  CHECK(largest > 1e12);
  // Both take the same doubles and t - centre is exact: only the powers of u, of condition below 20, round.
  CHECK(worst_value < 1e-13);
  CHECK(worst_sd < 1e-12);
  CHECK(worst_coefficient < 1e-11);
}

// Times of a clock that started 1e7 units ago.
TEST(Differentiation, KeepsItsDigitsFarFromZero) {
  std::vector<double> near, far, y;
  for (int i = 0; i < 9; ++i) {
    near.push_back(i / 8.0);
    far.push_back(1e7 + i / 8.0);  // exact
    y.push_back(std::sin(i / 3.0));
  }
  const auto a = contact::fit_cubic(near, y), b = contact::fit_cubic(far, y);
  for (int order = 0; order < 3; ++order) {
    DOUBLES_EQUAL(a->derivative(0.3125, order), b->derivative(1e7 + 0.3125, order), 1e-12);
    DOUBLES_EQUAL(a->derivative_with_sd(0.3125, order).sd, b->derivative_with_sd(1e7 + 0.3125, order).sd,
                  1e-13);
  }
}

TEST(Differentiation, OfEqualValuesIsZeroWithSdZero) {
  const std::vector<double> t{0.0, 0.2, 0.5, 0.7, 0.9, 1.0};
  const std::vector<double> y(6, 0.1);
  const auto fit = contact::fit_cubic(t, y);
  for (int order = 0; order < 3; ++order) {
    DOUBLES_EQUAL(order == 0 ? 0.1 : 0.0, fit->derivative(0.3, order), 0.0);
    DOUBLES_EQUAL(0.0, fit->derivative_with_sd(0.3, order).sd, 0.0);
  }
  CHECK_FALSE(contact::error_growth(*fit).has_value());
}

TEST(Differentiation, RefusesNumbersTooLargeForItsSums) {
  const std::vector<double> t{0.0, 0.2, 0.5, 0.7, 1.0};
  const std::vector<double> huge{1e300, -1e300, 1e300, -1e300, 1e300};
  const std::vector<double> tiny{0.0, 1e-300, 2e-300, 3e-300, 5e-300};
  CHECK_FALSE(contact::fit_cubic(t, huge).has_value());
  CHECK_FALSE(contact::fit_cubic(tiny, t).has_value());
}

// Table 12, corrected, in units of fractions.
TEST(Differentiation, GivesTheDerivedTableOfTheThesis) {
  const auto p = contact::fraction_polynomials(fits_as_printed("back_22"));
  DOUBLES_EQUAL(-1.647, (*p.vy_mps)[2], 0.002);
  DOUBLES_EQUAL(-17.48, (*p.omega_radps)[0], 0.005);
  DOUBLES_EQUAL(0.384, (*p.vx_mps)[2], 0.0005);
  DOUBLES_EQUAL(0.768, (*p.fx_n)[1], 0.0005);
  DOUBLES_EQUAL(-3.294, (*p.fy_n)[1], 0.004);
}

TEST(Differentiation, InRealUnitsAgreesWithItsPolynomials) {
  const auto fits = fits_as_printed("zero_23");
  const contact::ContactScale scale{
      .dwell_time_s = 5.1996e-3, .dwell_distance_m = 0.0629, .total_rotation_rad = -0.89};
  const auto p = contact::derived_polynomials(fits, scale);
  for (const double t : {0.0, 0.4, 1.0}) {
    const auto s = contact::derive(fits, scale, t);
    DOUBLES_EQUAL((*p.vx_mps)[0] + t * ((*p.vx_mps)[1] + t * (*p.vx_mps)[2]), s.vx_mps->value, 1e-12);
    DOUBLES_EQUAL((*p.fy_n)[0] + t * (*p.fy_n)[1], s.fy_n->value, 1e-10);
    DOUBLES_EQUAL((*p.torque_nm)[0] + t * (*p.torque_nm)[1], s.torque_nm->value, 1e-12);
    DOUBLES_EQUAL(s.vx_mps->value + 0.03255 * s.omega_radps->value, s.slip_mps->value, 1e-12);
  }
  // Table 13, corrected.
  DOUBLES_EQUAL(8.04, contact::derive(fits, scale, 1.0).vx_mps->value, 0.005);
  DOUBLES_EQUAL(129.8, contact::derive(fits, scale, 0.0).omega_radps->value, 0.1);
}

// The sd of a derivative is what many noisy sets show: 4000 of them tell it to 1.1 %.
TEST(Differentiation, StatesTheSpreadOfItsDerivatives) {
  const unsigned seed = 5;
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0.0, 0.01);
  const std::vector<double> t{0.0, 0.1, 0.15, 0.3, 0.42, 0.5, 0.61, 0.7, 0.77, 0.9, 1.0};
  std::array<std::array<double, 3>, 2> squares{}, stated{};
  constexpr int kSets = 4000;
  for (int i = 0; i < kSets; ++i) {
    std::vector<double> y;
    for (const double at : t) y.push_back(at * (at - 1.0) + noise(random));
    const auto fit = contact::fit_cubic(t, y);
    for (std::size_t where = 0; where < 2; ++where) {
      const double at = where == 0 ? 0.0 : 0.45;
      const std::array<double, 3> truth{at * (at - 1.0), 2 * at - 1.0, 2.0};
      for (std::size_t order = 0; order < 3; ++order) {
        const auto v = fit->derivative_with_sd(at, static_cast<int>(order));
        squares[where][order] += std::pow(v.value - truth[order], 2);
        stated[where][order] += v.sd * v.sd;
      }
    }
  }
  for (std::size_t where = 0; where < 2; ++where)
    for (std::size_t order = 0; order < 3; ++order)
      CHECK_TEXT(std::abs(std::sqrt(squares[where][order] / stated[where][order]) - 1.0) < 0.045,
                 ("seed " + std::to_string(seed)).c_str());
}

// What made the thesis leave it: the force's relative error is some four times the position's in the mean
// over the contact, for y some 20 % and more.
TEST(Differentiation, LosesPrecisionWithEachDerivative) {
  for (const auto& [name, set] : thesis_data(thesis::Version::corrected).contact) {
    const auto fits = contact::fit_fractions(set);
    for (const auto* fit : {&fits.x, &fits.y}) {
      const auto g = contact::error_growth(**fit);
      CHECK_TEXT(g->velocity > 1.5 * g->position, name.c_str());
      CHECK_TEXT(g->force > 1.3 * g->velocity, name.c_str());
      CHECK_TEXT(g->force > 0.15, name.c_str());
    }
  }
}

// The mean square of y'' = 2·c2 + 6·c3·t over 0…1 is 4(c2² + 3·c2·c3 + 3·c3²); a sum over 201 points is within
// a hundredth of it.
TEST(Differentiation, StatesTheErrorOfTheForceWhereItIsLargest) {
  const std::array t{0.0, 0.1, 0.2, 0.3, 0.4, 0.6};  // few images near lift-off
  const std::array y{0.0, 0.31, 0.52, 0.71, 0.78, 0.93};
  const auto fit = contact::fit_cubic(t, y);
  const double c2 = fit->coefficients[2], c3 = fit->coefficients[3];
  const double rms = 2.0 * std::sqrt(c2 * c2 + 3.0 * c2 * c3 + 3.0 * c3 * c3);
  const auto growth = contact::error_growth(*fit);
  DOUBLES_EQUAL(1.0, growth->force_at_ends * rms / fit->derivative_with_sd(1.0, 2).sd, 0.01);
  CHECK(fit->derivative_with_sd(1.0, 2).sd > fit->derivative_with_sd(0.0, 2).sd);
}

TEST(Differentiation, FindsWhereSpinAndSlipPassThroughZero) {
  const auto fits = fits_as_printed("back_22");
  const contact::ContactScale scale{
      .dwell_time_s = 5.1241e-3, .dwell_distance_m = 0.0648, .total_rotation_rad = -0.17};
  const auto zeros = contact::zero_crossings(fits, scale);
  CHECK(!zeros.omega.empty() && !zeros.rotation.empty());
  for (const double t : zeros.rotation) DOUBLES_EQUAL(0.0, fits.rotation->value(t), 1e-14);
  for (const double t : zeros.omega)
    DOUBLES_EQUAL(0.0, contact::derive(fits, scale, t).omega_radps->value, 1e-9);
  for (const double t : zeros.slip)
    DOUBLES_EQUAL(0.0, contact::derive(fits, scale, t).slip_mps->value, 1e-11);
  // It slides throughout: the slip has no zero, though the angle has.
  CHECK(zeros.slip.empty());
}

TEST(Differentiation, FindsNoZeroBeyondLiftOff) {
  const std::array t{0.0, 0.2, 0.4, 0.6, 0.8, 1.0};
  std::array<double, 6> fraction{};
  for (std::size_t i = 0; i < t.size(); ++i)
    fraction[i] = t[i] * (0.5 * t[i] - 1.05);  // its slope ends at 1.05
  contact::FractionFits fits;
  fits.x = fits.rotation = *contact::fit_cubic(t, fraction);
  const auto zeros = contact::zero_crossings(
      fits, {.dwell_time_s = 5e-3, .dwell_distance_m = 0.06, .total_rotation_rad = -0.2});
  CHECK(zeros.omega.empty() && zeros.slip.empty());
}

TEST(Differentiation, SolvesQuadraticsWithoutCancellation) {
  const auto roots = [](std::array<double, 3> c) { return contact::quadratic_roots(c, 0.0, 1.0); };
  DOUBLES_EQUAL(1e-12, roots({1e-12, -1.0, 1e-3}).at(0), 1e-26);
  LONGS_EQUAL(1, roots({1e-12, -1.0, 1e-3}).size());  // the other root lies at 1000
  LONGS_EQUAL(2, roots({0.08, -0.6, 1.0}).size());
  DOUBLES_EQUAL(0.2, roots({0.08, -0.6, 1.0}).at(0), 1e-15);
  LONGS_EQUAL(1, roots({0.25, -1.0, 1.0}).size());
  DOUBLES_EQUAL(0.5, roots({-1.0, 2.0, 0.0}).at(0), 0.0);
  CHECK(roots({1.0, 0.0, 1.0}).empty());
  CHECK(roots({1.0, 0.0, 0.0}).empty());
  CHECK(roots({0.0, 0.0, 0.0}).empty());
}
