#include <rapidcheck.h>
#include <cmath>
#include <limits>
#include <string>

#include "common/contact/condition_inputs.hpp"
#include "common/contact/integration/spin_pulse.hpp"
#include "tests/common/physics/thesis_folder.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using contact::SpinPulse;
using contact::SpinPulseInput;
using contact::SpinPulseState;
using impact::InputError;

namespace {

SpinPulseInput zero_23() {
  return {.ball = {}, .touchdown = {15.62, -6.71, 2.61}, .e = 0.86, .mu = 0.55, .dwell_s = 5.2e-3};
}

double between(int from, int to) { return 1e-3 * *rc::gen::inRange(from * 1000, to * 1000 + 1); }

SpinPulseInput any_impact() {
  SpinPulseInput in;
  in.touchdown = {between(-30, 30), -between(1, 30), 10.0 * between(-60, 60)};
  in.e = between(0, 1);
  in.mu = between(0, 2);
  in.dwell_s = 5e-3;
  return in;
}

template <typename Change>
InputError error_of(Change change) {
  SpinPulseInput in = zero_23();
  change(in);
  return SpinPulse::make(in).error();
}

void check(bool ok) { CHECK(ok); }

}  // namespace

TEST_GROUP(SpinPulses){};

// The rigid model knows the lift-off without going through the contact.
TEST(SpinPulses, LeaveAsTheRigidBodyDoes) {
  check(rc::check([] {
    const SpinPulseInput in = any_impact();
    const auto pulse = SpinPulse::make(in);
    const auto rigid = impact::rigid(in.ball, in.touchdown, in.e, in.mu);
    const SpinPulseState lo = pulse->at_fraction(1.0);
    // Rounding of a dozen operations on terms of at most 100 m/s.
    RC_ASSERT(std::abs(lo.vx_mps - rigid->lift_off.vx_mps) < 1e-12);
    RC_ASSERT(std::abs(lo.vy_mps - rigid->lift_off.vy_mps) < 1e-12);
    RC_ASSERT(std::abs(lo.omega_radps - rigid->lift_off.omega_radps) < 1e-10);
    RC_ASSERT(std::abs(lo.slip_mps - rigid->slip_lo_mps) < 1e-12);
  }));
}

// Friction acts in the contact line, so alpha·R·omega - vx changes by the offset's moment alone, at every
// instant; and its integral likewise.
TEST(SpinPulses, KeepTheirAngularMomentumAboutTheContactLine) {
  check(rc::check([] {
    SpinPulseInput in = any_impact();
    const double t = between(0, 1);
    in.offset_m = 1e-3 * between(-10, 10);
    const auto pulse = SpinPulse::make(in);
    const SpinPulseState s = pulse->at_fraction(t);
    const double arm = in.ball.alpha * in.ball.radius_m(), lever = in.offset_m / in.ball.radius_m();
    const double moment = arm * in.touchdown.omega_radps - in.touchdown.vx_mps;
    const double pushed = lever * (s.vy_mps - in.touchdown.vy_mps);
    RC_ASSERT(std::abs(arm * s.omega_radps - s.vx_mps - moment - pushed) < 1e-12);
    const double time_s = t * in.dwell_s;
    const double shoved = lever * (s.y_m - in.touchdown.vy_mps * time_s);
    RC_ASSERT(std::abs(arm * s.rotation_rad - s.x_m - moment * time_s - shoved) < 1e-14);
  }));
}

TEST(SpinPulses, SlipEverLessUntilTheyRollAndLoseEnergyAllTheWay) {
  check(rc::check([] {
    const SpinPulseInput in = any_impact();
    const auto pulse = SpinPulse::make(in);
    const auto energy = [&in](const SpinPulseState& s) {
      return s.vx_mps * s.vx_mps + in.ball.alpha * std::pow(in.ball.radius_m() * s.omega_radps, 2);
    };
    SpinPulseState last = pulse->at_fraction(0.0);
    for (int i = 1; i <= 50; ++i) {
      const SpinPulseState s = pulse->at_fraction(i / 50.0);
      RC_ASSERT(std::abs(s.slip_mps) <= std::abs(last.slip_mps) + 1e-13);
      RC_ASSERT(s.slip_mps * last.slip_mps >= -1e-24);
      RC_ASSERT(energy(s) <= energy(last) * (1.0 + 1e-14) + 1e-12);
      last = s;
    }
    if (pulse->grip_fraction()) RC_ASSERT(last.slip_mps == 0.0);
  }));
}

TEST(SpinPulses, AreContinuousAtTheGripWhereFrictionAloneJumps) {
  const auto pulse = SpinPulse::make(zero_23());
  const double grip = *pulse->grip_fraction();
  const SpinPulseState before = pulse->at_fraction(grip * (1.0 - 1e-13));
  const SpinPulseState after = pulse->at_fraction(grip * (1.0 + 1e-13));
  // A share of 2e-13 of 5.2 ms at 15 m/s, 300 rad/s and accelerations of up to 2e5.
  DOUBLES_EQUAL(before.x_m, after.x_m, 1e-13);
  DOUBLES_EQUAL(before.rotation_rad, after.rotation_rad, 1e-12);
  DOUBLES_EQUAL(before.vx_mps, after.vx_mps, 1e-11);
  DOUBLES_EQUAL(before.omega_radps, after.omega_radps, 1e-9);
  CHECK(before.fx_n < -10.0);
  DOUBLES_EQUAL(0.0, after.fx_n, 0.0);
  CHECK_EQUAL(Regime::grips, pulse->regime());
}

TEST(SpinPulses, OfAnOffsetForceRollOnWithRollingFriction) {
  SpinPulseInput in = zero_23();
  in.offset_m = 0.0025;
  const auto pulse = SpinPulse::make(in);
  const SpinPulseState s = pulse->at_fraction(0.9);
  DOUBLES_EQUAL(0.0, s.slip_mps, 0.0);
  // R·omega = -vx throughout needs alpha·R·F_x... = -(R·F_x + d·F_y)/R, i.e. F_x = -d/(R(1 + alpha))·F_y.
  DOUBLES_EQUAL(-in.offset_m / (in.ball.radius_m() * 1.55), s.fx_n / s.fy_n, 1e-15);
  DOUBLES_EQUAL(0.0, s.vx_mps + in.ball.radius_m() * s.omega_radps, 1e-12);
  CHECK(s.vx_mps < SpinPulse::make(zero_23())->at_fraction(0.9).vx_mps);
}

TEST(SpinPulses, WithTooLittleFrictionAreTurnedOverByAnOffset) {
  SpinPulseInput in = zero_23();
  in.touchdown.omega_radps = -500.0;  // faster than rolling: slips backwards
  in.mu = 0.03;
  in.offset_m = 0.02;
  const auto pulse = SpinPulse::make(in);
  CHECK(pulse->grip_fraction().has_value());
  CHECK_EQUAL(Regime::slides, pulse->regime());
  CHECK(pulse->at_fraction(0.01).slip_mps < 0.0);
  CHECK(pulse->at_fraction(1.0).slip_mps > 0.0);
  CHECK(pulse->at_fraction(0.99).fx_n < 0.0);
}

TEST(SpinPulses, ThatRollAlreadyKeepRolling) {
  SpinPulseInput in = zero_23();
  in.touchdown = {0.0, -6.71, 0.0};
  const auto pulse = SpinPulse::make(in);
  DOUBLES_EQUAL(0.0, *pulse->grip_fraction(), 0.0);
  DOUBLES_EQUAL(0.0, pulse->total_rotation_rad(), 0.0);
}

// Without its grip the motion along the surface is the thesis's.
TEST(SpinPulses, ThatSlideThroughoutMoveAsThePulseOfTheThesis) {
  for (const auto form : {impact::PulseForm::exact, impact::PulseForm::simplified}) {
    SpinPulseInput in = zero_23();
    in.mu = 0.3;
    in.form = form;
    const auto pulse = SpinPulse::make(in);
    const auto plain = impact::SinePulse::make(form, {15.62, -6.71, 0.86, 0.3, 5.2e-3});
    CHECK_FALSE(pulse->grip_fraction().has_value());
    for (const double t : {0.1, 0.5, 0.9, 1.0}) {
      DOUBLES_EQUAL(plain->at_fraction(t).x_m, pulse->at_fraction(t).x_m, 1e-16);
      DOUBLES_EQUAL(plain->at_fraction(t).y_m, pulse->at_fraction(t).y_m, 0.0);
      DOUBLES_EQUAL(plain->at_fraction(t).vx_mps, pulse->at_fraction(t).vx_mps, 1e-14);
    }
  }
}

// With alpha = 2/3, as the thesis has it, the three sets it found sliding throughout and no others.
TEST(SpinPulses, GripInAllConditionsOfTheThesisButThree) {
  std::string sliding;
  for (const auto& c : testing::thesis_data(thesis::Version::corrected).conditions) {
    const auto pulse =
        SpinPulse::make(contact::spin_pulse_input(c, impact::PulseForm::exact, ball::kThinShellAlpha));
    if (pulse->regime() == Regime::slides) sliding += c.name() + " ";
  }
  CHECK_EQUAL("zero_17 back_17 back_22 ", sliding);
}

TEST(SpinPulses, RefuseWhatIsOutOfRangeByType) {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  CHECK(error_of([](auto& in) { in.mu = -0.1; }) == InputError::friction_negative);
  CHECK(error_of([](auto& in) { in.e = 1.1; }) == InputError::restitution_out_of_range);
  CHECK(error_of([](auto& in) { in.dwell_s = 0.0; }) == InputError::dwell_not_positive);
  CHECK(error_of([](auto& in) { in.offset_m = 0.0326; }) == InputError::offset_out_of_range);
  CHECK(error_of([](auto& in) { in.ball.alpha = 0.7; }) == InputError::ball_out_of_range);
  CHECK(error_of([](auto& in) { in.touchdown.vy_mps = 0.0; }) == InputError::not_approaching);
  CHECK(error_of([](auto& in) { in.form = impact::PulseForm::simplified, in.e = 0.0; }) ==
        InputError::damping_undefined);
  for (double SpinPulseInput::*member :
       {&SpinPulseInput::e, &SpinPulseInput::mu, &SpinPulseInput::dwell_s, &SpinPulseInput::offset_m})
    for (const double value : {kInf, -kInf, std::nan("")}) {
      SpinPulseInput in = zero_23();
      in.*member = value;
      CHECK_FALSE(SpinPulse::make(in).has_value());
    }
  SpinPulseInput huge = zero_23();
  huge.touchdown = {1e308, -1e308, 1e308};
  CHECK_FALSE(SpinPulse::make(huge).has_value());
}
