// Properties that hold for every impact, on random ones. A failure prints the seed that repeats it
// (RC_PARAMS).
#include <rapidcheck.h>

#include <cmath>

#include "common/impact/closed_form/rebound.hpp"

#include <CppUTest/TestHarness.h>

using strobe::Regime;
using namespace strobe::impact;
using strobe::ball::Ball;

namespace {

struct Case {
  Ball ball;
  Motion in;
  Coefficients c;
};

double between(double low, double high) {
  // Ends and middle come up often: they are where regimes meet.
  const int step = *rc::gen::inRange(0, 1'000'001);
  return low + (high - low) * step / 1e6;
}

double sometimes_zero(double low, double high) {
  return *rc::gen::inRange(0, 8) == 0 ? 0.0 : between(low, high);
}

Case any_impact() {
  Case x;
  x.ball = {.diameter_m = between(0.02, 0.3), .mass_kg = 0.0576, .alpha = between(0.2, 2.0 / 3.0)};
  x.in.vx_mps = sometimes_zero(-40.0, 40.0);
  x.in.vy_mps = between(-40.0, -0.01);
  const int kind = *rc::gen::inRange(0, 6);
  const double radius = x.ball.radius_m();
  x.in.omega_radps = kind == 0 ? 0.0 : kind == 1 ? -x.in.vx_mps / radius : between(-60.0, 60.0) / radius;
  x.c = {.e = between(0.0, 1.0),
         .mu = sometimes_zero(0.0, 1.5),
         .e_x = sometimes_zero(-1.0, 1.0),
         .offset_m = sometimes_zero(0.0, 0.3) * radius,
         .offset_reference_mps = between(0.01, 10.0)};
  return x;
}

double tangential_energy(const Ball& b, const Motion& m) {
  return 0.5 * (m.vx_mps * m.vx_mps + b.alpha * std::pow(b.radius_m() * m.omega_radps, 2));
}

double speed_scale(const Case& x) {
  return std::abs(x.in.vx_mps) + std::abs(x.ball.radius_m() * x.in.omega_radps) + std::abs(x.in.vy_mps);
}

}  // namespace

TEST_GROUP(ReboundProperties){};

TEST(ReboundProperties, AMirroredImpactReboundsMirrored) {
  CHECK(rc::check("mirror", [] {
    const Case x = any_impact();
    const auto r = *grip(x.ball, x.in, x.c);
    const auto m = *grip(x.ball, {-x.in.vx_mps, x.in.vy_mps, -x.in.omega_radps}, x.c);
    RC_ASSERT(m.lift_off.vx_mps == -r.lift_off.vx_mps);
    RC_ASSERT(m.lift_off.omega_radps == -r.lift_off.omega_radps);
    RC_ASSERT(m.lift_off.vy_mps == r.lift_off.vy_mps);
    RC_ASSERT(m.regime == r.regime);
  }));
}

// Rounding: some ten operations on squares of the speeds.
TEST(ReboundProperties, NoImpactAddsEnergy) {
  CHECK(rc::check("energy", [] {
    const Case x = any_impact();
    const auto r = *grip(x.ball, x.in, x.c);
    const double slack = 1e-14 * std::pow(speed_scale(x), 2);
    RC_ASSERT(tangential_energy(x.ball, r.lift_off) <= tangential_energy(x.ball, x.in) + slack);
    RC_ASSERT(std::abs(r.lift_off.vy_mps) <= std::abs(x.in.vy_mps));
  }));
}

TEST(ReboundProperties, FrictionStaysWithinItsLimitAndTheTorquesBalance) {
  CHECK(rc::check("friction", [] {
    const Case x = any_impact();
    const auto r = *grip(x.ball, x.in, x.c);
    const double impulse = (1.0 + x.c.e) * std::abs(x.in.vy_mps);
    const double dvx = r.lift_off.vx_mps - x.in.vx_mps, slack = 1e-13 * speed_scale(x);
    RC_ASSERT(std::abs(dvx) <= x.c.mu * impulse + slack);
    const double radius = x.ball.radius_m();
    const double turning = x.ball.alpha * radius * (r.lift_off.omega_radps - x.in.omega_radps);
    RC_ASSERT(std::abs(turning - (dvx + r.offset_m * impulse / radius)) <= slack);
    RC_ASSERT(std::abs(r.offset_m) <= x.c.offset_m);
    RC_ASSERT(r.offset_m * (x.in.vx_mps - radius * x.in.omega_radps) >= 0.0);
  }));
}

// The outputs follow the inputs without jumps; where the offset is lessened for energy's sake they may do so
// as a square root does: sqrt(1e-10) of the speeds, with room for the slopes.
TEST(ReboundProperties, ReboundsAreContinuousInTheTouchdown) {
  CHECK(rc::check("continuity", [] {
    const Case x = any_impact();
    const double scale = speed_scale(x), radius = x.ball.radius_m();
    Motion near = x.in;
    near.vx_mps += 1e-10 * scale * *rc::gen::inRange(-1, 2);
    near.vy_mps *= 1.0 + 1e-10 * *rc::gen::inRange(-1, 2);
    near.omega_radps += 1e-10 * scale / radius * *rc::gen::inRange(-1, 2);
    const auto a = *grip(x.ball, x.in, x.c);
    const auto b = *grip(x.ball, near, x.c);
    const double limit = 1e-3 * scale;
    RC_ASSERT(std::abs(a.lift_off.vx_mps - b.lift_off.vx_mps) <= limit);
    RC_ASSERT(radius * std::abs(a.lift_off.omega_radps - b.lift_off.omega_radps) <= limit);
  }));
}

TEST(ReboundProperties, WithoutAnOffsetAGripTurnsTheSlipIntoItsRestitutionAndASlideNeverReversesIt) {
  CHECK(rc::check("slip", [] {
    Case x = any_impact();
    x.c.offset_m = 0.0;
    const auto r = *grip(x.ball, x.in, x.c);
    const double slip = x.in.vx_mps + x.ball.radius_m() * x.in.omega_radps;
    const double slack = 1e-13 * speed_scale(x);
    if (r.regime == Regime::grips) {
      RC_ASSERT(std::abs(r.slip_lo_mps + x.c.e_x * slip) <= slack);
    } else {
      RC_ASSERT((r.slip_lo_mps + x.c.e_x * slip) * slip >= -slack * std::abs(slip));
      RC_ASSERT(std::abs(r.slip_lo_mps) <= std::abs(slip) + slack);
    }
  }));
}
