// The contact integrated in doubles against 34 digits, over the whole range of inputs.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>
#include <string>

#include "tests/common/contact_ode/reference.hpp"
#include "tests/support/repetitions.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using impact::ContactCoefficients;
using impact::Motion;

namespace {

struct Case {
  Motion touchdown;
  ContactCoefficients coefficients;
};

class Draws {
 public:
  explicit Draws(unsigned seed) : random_(seed) {}
  double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  double over_decades(double low, double high) { return std::exp(between(std::log(low), std::log(high))); }
  bool one_in(int n) { return std::uniform_int_distribution<int>(1, n)(random_) == 1; }

 private:
  std::mt19937_64 random_;
};

/// Angle .01 to 90 degrees, speed 1e-6 to 1e3 m/s, |omega| 0 to 1e5 rad/s, e .14 to 1, mu 0 to 10, dwell time
/// 1 us to 1 s; a third with a spin of the order of rolling, where grip and slip change most.
Case draw(Draws& draws) {
  const double degree = std::numbers::pi / 180.0, speed = draws.over_decades(1e-6, 1e3);
  const double angle = draws.one_in(2) ? draws.over_decades(0.01, 90.0) : draws.between(5.0, 90.0);
  Case c;
  c.touchdown = {speed * std::cos(angle * degree), -speed * std::sin(angle * degree), 0.0};
  if (draws.one_in(3))
    c.touchdown.omega_radps = std::clamp(draws.between(-3.0, 3.0) * speed / 0.03255, -1e5, 1e5);
  else if (!draws.one_in(6))
    c.touchdown.omega_radps = (draws.one_in(2) ? 1.0 : -1.0) * draws.over_decades(1e-3, 1e5);
  c.coefficients.e = draws.one_in(10) ? 1.0 : draws.between(0.14, 1.0);
  c.coefficients.mu = draws.one_in(20) ? 0.0 : draws.over_decades(0.01, 10.0);
  c.coefficients.dwell_s = draws.over_decades(1e-6, 1.0);
  c.coefficients.stiffness_ratio = draws.between(0.3, 3.0);
  c.coefficients.damping_ratio = draws.one_in(3) ? 0.0 : draws.between(0.1, 2.0);
  c.coefficients.offset_share = draws.one_in(3) ? 0.0 : draws.between(0.0, 0.3);
  return c;
}

std::string text_of(const Case& c) {
  char line[400];
  std::snprintf(line, sizeof line,
                "vx %.17g vy %.17g omega %.17g e %.17g mu %.17g dwell %.17g kt %.17g ct %.17g offset %.17g",
                c.touchdown.vx_mps, c.touchdown.vy_mps, c.touchdown.omega_radps, c.coefficients.e,
                c.coefficients.mu, c.coefficients.dwell_s, c.coefficients.stiffness_ratio,
                c.coefficients.damping_ratio, c.coefficients.offset_share);
  return line;
}

double relative(const testing::Quad& got, const testing::Quad& expected, double scale) {
  return std::abs(static_cast<double>(got - expected)) / scale;
}

/// Largest error of lift-off, the changes of the tangential motion over the scale of such changes: friction's
/// impulse, or what stops the slip where that is less, and the offset's couple. The lift-off speeds
/// themselves are rounded, so that their last bits count as nothing.
double error_of(const Case& c, const impact::ContactSummary& got,
                const testing::ReferenceContact& reference) {
  const ball::Ball ball{.alpha = impact::kContactAlpha};
  const double radius = ball.radius_m(), normal = -c.touchdown.vy_mps;
  const double slip = std::abs(std::fma(radius, c.touchdown.omega_radps, c.touchdown.vx_mps));
  const double depth = std::min(1.0, normal * c.coefficients.dwell_s / 3.0 / radius);
  const double scale = std::min(2.0 * c.coefficients.mu * normal, slip) +
                       2.0 * c.coefficients.offset_share * std::sqrt(depth) * normal;
  const double rounding =
      4.0 * std::numeric_limits<double>::epsilon() *
      (std::abs(c.touchdown.vx_mps) + radius * std::abs(c.touchdown.omega_radps) + normal);
  const double floor = scale + rounding / 1e-9;
  return std::max(
      {relative(got.lift_off.vy_mps, reference.vy_mps, normal),
       relative(got.lift_off.vx_mps, reference.vx_mps, floor),
       relative(radius * testing::Quad(got.lift_off.omega_radps), radius * reference.omega_radps, floor),
       relative(got.dwell_s, reference.dwell_s, c.coefficients.dwell_s)});
}

testing::ReferenceContact reference_of(const Case& c, int intervals) {
  return testing::reference_contact({.alpha = impact::kContactAlpha}, c.touchdown, c.coefficients, intervals);
}

}  // namespace

TEST_GROUP(ContactReference){};

// Halving the reference's steps changes it by far less than it is used to tell.
TEST(ContactReference, TheReferenceItselfHasConverged) {
  Draws draws(7);
  for (int i = 0; i < 6; ++i) {
    const Case c = draw(draws);
    const auto coarse = reference_of(c, 60);
    const auto fine = reference_of(c, 120);
    const double scale = std::abs(c.touchdown.vx_mps) + std::abs(c.touchdown.vy_mps) +
                         0.03255 * std::abs(c.touchdown.omega_radps);
    DOUBLES_EQUAL(0.0, relative(coarse.vx_mps, fine.vx_mps, scale), 1e-11);
    DOUBLES_EQUAL(0.0, relative(coarse.omega_radps, fine.omega_radps, scale / 0.03255), 1e-11);
  }
}

TEST(ContactReference, AToleranceOf1e9HoldsNineDigitsOverTheWholeRange) {
  const unsigned seed = 20261121;
  Draws draws(seed);
  double worst = 0.0;
  for (int i = 0; i < testing::repetitions(100); ++i) {
    const Case c = draw(draws);
    const auto got =
        impact::simulate({.alpha = impact::kContactAlpha}, c.touchdown, c.coefficients, {.tolerance = 1e-9});
    CHECK_TEXT(got.has_value(), text_of(c).c_str());
    const double error = error_of(c, *got, reference_of(c, 200));
    worst = std::max(worst, error);
    CHECK_TEXT(error <= 1e-9,
               (std::to_string(i) + ": " + std::to_string(error * 1e9) + "e-9: " + text_of(c)).c_str());
  }
  UT_PRINT(("worst: " + std::to_string(worst * 1e9) + "e-9, seed " + std::to_string(seed)).c_str());
}

TEST(ContactReference, GripTimesAreThoseOfTheReference) {
  for (const double angle_vy : {-5.0, -8.0, -12.0, -15.0}) {
    const Case c{{15.0, angle_vy, 30.0}, {}};
    const auto got = impact::simulate({.alpha = impact::kContactAlpha}, c.touchdown, c.coefficients);
    const auto reference = reference_of(c, 80);
    CHECK_EQUAL(reference.first_grip_s.has_value(), got->skid_to_grip_s.has_value());
    if (got->skid_to_grip_s)
      DOUBLES_EQUAL(0.0, relative(*got->skid_to_grip_s, *reference.first_grip_s, 5e-3), 1e-8);
  }
}
