#include "common/impact/closed_form/brody.hpp"

#include <rapidcheck.h>

#include <cmath>
#include <limits>

#include "tests/common/impact_fit/check.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::impact;
using strobe::testing::real;

namespace {

constexpr double kRadius = ball::kThesisDiameter_m / 2.0;

struct Bounce {
  ball::Ball ball;
  Motion touchdown;
  double e = 0.0, mu = 0.0;

  double spin() const { return ball.radius_m() * touchdown.omega_radps; }
  double speed() const {
    return std::abs(touchdown.vx_mps) + std::abs(spin()) + std::abs(touchdown.vy_mps) * (1.0 + mu);
  }
};

Bounce any_bounce() {
  Bounce b;
  b.ball.alpha = real(0.3, 2.0 / 3.0);
  b.touchdown = {real(-50.0, 50.0), -real(0.01, 50.0), real(-1500.0, 1500.0)};
  b.e = real(0.0, 1.0);
  b.mu = real(0.0, 1.5);
  return b;
}

/// vx - alpha·R·omega: friction at the surface cannot change it.
double conserved(const Bounce& b, const Motion& m) {
  return m.vx_mps - b.ball.alpha * b.ball.radius_m() * m.omega_radps;
}

}  // namespace

TEST_GROUP(Brody){};

// Rounding: a handful of operations on numbers of the size of speed(), divided by alpha >= 0.3.
TEST(Brody, AngularMomentumAboutTheContactPointIsKeptByAllThree) {
  CHECK(rc::check([] {
    const Bounce b = any_bounce();
    const double before = conserved(b, b.touchdown), tolerance = 1e-14 * b.speed();
    const auto slid = slide(b.ball, b.touchdown, b.e, b.mu);
    const auto rolled = roll(b.ball, b.touchdown, b.e);
    const auto chosen = slide_or_roll(b.ball, b.touchdown, b.e, b.mu);
    RC_ASSERT(std::abs(conserved(b, slid->lift_off) - before) <= tolerance);
    RC_ASSERT(std::abs(conserved(b, rolled->lift_off) - before) <= tolerance);
    RC_ASSERT(std::abs(conserved(b, chosen->rebound.lift_off) - before) <= tolerance);
  }));
}

TEST(Brody, ARollingBallDoesNotSlipAndASlidingOneLosesMuTimesTheNormalImpulse) {
  CHECK(rc::check([] {
    const Bounce b = any_bounce();
    const auto rolled = roll(b.ball, b.touchdown, b.e);
    RC_ASSERT(std::abs(rolled->lift_off.vx_mps + b.ball.radius_m() * rolled->lift_off.omega_radps) <=
              1e-15 * b.speed());
    const auto slid = slide(b.ball, b.touchdown, b.e, b.mu);
    const double lost = std::abs(slid->lift_off.vx_mps - b.touchdown.vx_mps);
    RC_ASSERT(std::abs(lost + b.mu * (1.0 + b.e) * b.touchdown.vy_mps) <= 1e-14 * b.speed());
  }));
}

TEST(Brody, TheChoiceNeverTurnsTheSlipAround) {
  CHECK(rc::check([] {
    const Bounce b = any_bounce();
    const auto chosen = slide_or_roll(b.ball, b.touchdown, b.e, b.mu);
    const double slip = b.touchdown.vx_mps + b.spin();
    RC_ASSERT(chosen->rebound.slip_lo_mps * slip >= -1e-14 * b.speed() * std::abs(slip));
    RC_ASSERT((chosen->rebound.regime == Regime::slides) == (b.mu < chosen->rolling_impulse_ratio));
  }));
}

// Two ways to the same models; near the border of the regimes both give the same motion.
TEST(Brody, TheChoiceIsTheRigidBodysRebound) {
  CHECK(rc::check([] {
    const Bounce b = any_bounce();
    const auto chosen = slide_or_roll(b.ball, b.touchdown, b.e, b.mu);
    const auto whole = rigid(b.ball, b.touchdown, b.e, b.mu);
    RC_ASSERT(std::abs(chosen->rebound.lift_off.vx_mps - whole->lift_off.vx_mps) <= 1e-14 * b.speed());
    RC_ASSERT(std::abs(chosen->rebound.lift_off.omega_radps - whole->lift_off.omega_radps) <=
              1e-13 * b.speed() / b.ball.radius_m());
  }));
}

TEST(Brody, WithoutSlipThereIsNoFriction) {
  const auto r = slide({}, {0.0, -8.0, 0.0}, 0.7, 0.5);
  DOUBLES_EQUAL(0.0, r->lift_off.vx_mps, 0.0);
  DOUBLES_EQUAL(0.0, r->impulse_ratio, 0.0);
}

TEST(Brody, RefusesWhatTheRigidBodyRefuses) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_EQUAL(InputError::not_finite, slide({}, {nan, -8.0, 0.0}, 0.7, 0.5).error());
  CHECK_EQUAL(InputError::not_approaching, roll({}, {1.0, 8.0, 0.0}, 0.7).error());
  CHECK_EQUAL(InputError::restitution_out_of_range, slide_or_roll({}, {1.0, -8.0, 0.0}, 1.7, 0.5).error());
  CHECK_EQUAL(InputError::friction_negative, slide_or_roll({}, {1.0, -8.0, 0.0}, 0.7, -0.5).error());
}
