#include <cmath>
#include <limits>
#include <numbers>

#include "common/impact/closed_form/sine_pulse.hpp"

#include "tests/support/string_from.hpp"

using strobe::Regime;
using namespace strobe::impact;
using strobe::ball::Ball;

namespace {

const PulseInput kZero23{15.62, -6.701, 0.8650, 0.55, 5.1996e-3, 0.0576};

SinePulse pulse(PulseForm form, const PulseInput& in = kZero23) { return *SinePulse::make(form, in); }

/// Composite Simpson over 0…1 of the time fraction.
template <typename F>
double integral(F function, int steps) {
  double sum = function(0.0) + function(1.0);
  for (int i = 1; i < steps; ++i) sum += function(static_cast<double>(i) / steps) * (i % 2 == 1 ? 4.0 : 2.0);
  return sum / (3.0 * steps);
}

}  // namespace

TEST_GROUP(DampedSinePulse){};

// f = -ln(e)/pi; to the four decimals of Table 15's e an error of 5e-5/(pi e) is 2e-5.
TEST(DampedSinePulse, SimplifiedDampingIsThatOfTable15) {
  DOUBLES_EQUAL(0.046, *damping_from_restitution(PulseForm::simplified, 0.8650), 0.0005);
  DOUBLES_EQUAL(std::exp(-std::numbers::pi * *damping_from_restitution(PulseForm::simplified, 0.9059)),
                0.9059, 1e-15);
  DOUBLES_EQUAL(std::exp(-std::numbers::pi * *damping_from_restitution(PulseForm::simplified, 0.8010)),
                0.8010, 1e-15);
}

// e = 2/(1+f²)-1 at most; the largest exact damping solves (1 + exp(-f·pi)) = 1 + f².
TEST(DampedSinePulse, ExactDampingIsAtMost04745) {
  const double f = *damping_from_restitution(PulseForm::exact, 0.0);
  DOUBLES_EQUAL(0.4745, f, 0.00005);
  DOUBLES_EQUAL(f * f, std::exp(-f * std::numbers::pi), 1e-15);
}

TEST(DampedSinePulse, ABallThatLosesNothingIsNotDamped) {
  DOUBLES_EQUAL(0.0, *damping_from_restitution(PulseForm::exact, 1.0), 0.0);
  DOUBLES_EQUAL(0.0, *damping_from_restitution(PulseForm::simplified, 1.0), 0.0);
}

TEST(DampedSinePulse, RefusesInputsOutOfRange) {
  const auto error = [](PulseForm form, auto change) {
    PulseInput in = kZero23;
    change(in);
    return SinePulse::make(form, in).error();
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(error(PulseForm::exact, [](auto& in) { in.e = -0.01; }) == InputError::restitution_out_of_range);
  CHECK(error(PulseForm::exact, [](auto& in) { in.e = 1.01; }) == InputError::restitution_out_of_range);
  CHECK(error(PulseForm::simplified, [](auto& in) { in.e = 0.0; }) == InputError::damping_undefined);
  CHECK(error(PulseForm::exact, [nan](auto& in) { in.e = nan; }) == InputError::not_finite);
  CHECK(error(PulseForm::exact, [nan](auto& in) { in.impulse_ratio = nan; }) == InputError::not_finite);
  CHECK(error(PulseForm::exact, [](auto& in) { in.vy_td_mps = 0.0; }) == InputError::not_approaching);
  CHECK(error(PulseForm::exact, [](auto& in) { in.dwell_s = 0.0; }) == InputError::dwell_not_positive);
  CHECK(error(PulseForm::exact, [](auto& in) { in.mass_kg = 0.0; }) == InputError::ball_out_of_range);
}

TEST(DampedSinePulse, StartsAtTheTouchdownAndEndsWithTheReboundOfItsRestitution) {
  for (const PulseForm form : {PulseForm::exact, PulseForm::simplified}) {
    const PulseState start = pulse(form).at_fraction(0.0);
    DOUBLES_EQUAL(15.62, start.vx_mps, 0.0);
    DOUBLES_EQUAL(-6.701, start.vy_mps, 0.0);
    DOUBLES_EQUAL(0.0, start.x_m, 0.0);
    DOUBLES_EQUAL(0.0, start.y_m, 0.0);
    DOUBLES_EQUAL(0.0, start.fy_n, 0.0);
    const PulseState end = pulse(form).at_fraction(1.0);
    DOUBLES_EQUAL(0.8650 * 6.701, end.vy_mps, 1e-14);
    DOUBLES_EQUAL(15.62 - 0.55 * 1.8650 * 6.701, end.vx_mps, 1e-14);
    DOUBLES_EQUAL(1.0, end.impulse_fraction, 1e-15);
    DOUBLES_EQUAL(0.0, end.fy_n, 0.0);
  }
}

// Simpson's error with 200 steps over a half-wave is about (pi/200)^4/180 of it, 3e-10.
TEST(DampedSinePulse, ExactVelocityAndPositionAreTheIntegralsOfTheForce) {
  const SinePulse p = pulse(PulseForm::exact);
  const double impulse_mps =
      integral([&p](double t) { return p.at_fraction(t).fy_n; }, 200) * 5.1996e-3 / 0.0576;
  DOUBLES_EQUAL(1.0, impulse_mps / (1.8650 * 6.701), 1e-9);
  const double distance_m = integral([&p](double t) { return p.at_fraction(t).vx_mps; }, 200) * 5.1996e-3;
  DOUBLES_EQUAL(1.0, distance_m / p.at_fraction(1.0).x_m, 1e-9);
  const double drop_m = integral([&p](double t) { return p.at_fraction(t).vy_mps; }, 200) * 5.1996e-3;
  DOUBLES_EQUAL(p.at_fraction(1.0).y_m, drop_m, 1e-11);
}

// Stated as up to 4.5 % of the touchdown velocity at f = 0.046 and 12 % at 0.128, in two digits.
TEST(DampedSinePulse, TheSimplificationCostsUpToFourAndAHalfPercentAtTheThesissDamping) {
  const auto cost = [](double f) {
    const double e = std::exp(-std::numbers::pi * f);
    double worst = 0.0;
    for (int i = 0; i <= 1000; ++i) {
      const double theta = std::numbers::pi * i / 1000.0;
      const double exact =
          (1.0 - std::exp(-f * theta) * (f * std::sin(theta) + std::cos(theta))) / (1.0 + f * f) - 1.0;
      const double simple =
          *SinePulse::make(PulseForm::simplified, {0.0, -1.0, e, 0.0, 5e-3}).map([&](const SinePulse& p) {
            return p.at_fraction(i / 1000.0).vy_mps;
          });
      worst = std::max(worst, std::abs(exact - simple));
    }
    return worst;
  };
  DOUBLES_EQUAL(0.045, cost(0.046), 0.0015);
  DOUBLES_EQUAL(0.12, cost(0.128), 0.005);
}

TEST(DampedSinePulse, FindsWhenAShareOfTheImpulseHasActed) {
  for (const PulseForm form : {PulseForm::exact, PulseForm::simplified}) {
    const SinePulse p = pulse(form);
    for (const double share : {1e-12, 1e-6, 0.1, 0.5, 0.9, 0.999, 0.999999})
      DOUBLES_EQUAL(share, p.at_fraction(p.fraction_at_impulse(share)).impulse_fraction, 1e-12);
    DOUBLES_EQUAL(0.0, p.fraction_at_impulse(0.0), 0.0);
  }
  DOUBLES_EQUAL(1.0, pulse(PulseForm::exact).fraction_at_impulse(1.0), 0.0);
}

TEST(DampedSinePulse, CarriesTheSpinToWhereItStopsSlipping) {
  const Ball ball{.alpha = 2.0 / 3.0};
  const Motion touchdown{14.49, -9.95, 0.0};
  const auto p = pulse_rebound(PulseForm::exact, ball, touchdown, 0.77, 0.55, 4.84e-3);
  CHECK_EQUAL(Regime::grips, p->rebound.regime);
  DOUBLES_EQUAL(0.6 * 14.49, p->rebound.lift_off.vx_mps, 1e-12);  // (3·vx - 2·R·omega)/5
  // Until it grips, friction has taken 2/5 of vx: the impulse that this needs over the one there is.
  const auto sliding = SinePulse::make(PulseForm::exact, {14.49, -9.95, 0.77, 0.55, 4.84e-3});
  DOUBLES_EQUAL(0.6 * 14.49, sliding->at_fraction(p->grip_fraction).vx_mps, 1e-10);
  CHECK(p->grip_fraction > 0.0 && p->grip_fraction < 1.0);
  // Slower than at touchdown, faster than at lift-off throughout.
  CHECK(p->dwell_distance_m < 14.49 * 4.84e-3 && p->dwell_distance_m > 0.6 * 14.49 * 4.84e-3);
}

TEST(DampedSinePulse, DepthIsWhereTheBallTurnsAndTheForceItsLargest) {
  for (const PulseForm form : {PulseForm::exact, PulseForm::simplified}) {
    const auto p = pulse_rebound(form, Ball{}, {15.62, -6.701, 0.0}, 0.8650, 0.2, 5.1996e-3);
    const SinePulse q = pulse(form);
    double depth = 0.0, force = 0.0;
    for (int i = 0; i <= 2000; ++i) {
      depth = std::max(depth, -q.at_fraction(i / 2000.0).y_m);
      force = std::max(force, q.at_fraction(i / 2000.0).fy_n);
    }
    // Within a step of 1/2000 of a flat top: (pi/4000)²/2 = 3e-7.
    DOUBLES_EQUAL(1.0, p->depth_m / depth, 4e-7);
    DOUBLES_EQUAL(1.0, p->max_force_n / force, 4e-7);
    DOUBLES_EQUAL(1.0, p->grip_fraction, 0.0);  // mu .2 is too little to stop the slip
    DOUBLES_EQUAL(q.input().dwell_s * 15.62, p->dwell_distance_m, 0.2 * 6.701 * 2.0 * 5.2e-3);
  }
}
