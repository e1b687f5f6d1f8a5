#include <boost/math/constants/constants.hpp>
#include <boost/math/quadrature/gauss.hpp>
#include <boost/math/tools/toms748_solve.hpp>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <random>
#include <rapidcheck.h>
#include <string>

#include "common/contact/condition_inputs.hpp"
#include "common/contact/spin_pulse.hpp"
#include "tests/common/physics/thesis_folder.hpp"
#include "tests/support/property.hpp"
#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using contact::SpinPulse;
using contact::SpinPulseInput;
using contact::SpinPulseState;
using impact::InputError;
using testing::between;
using testing::holds_of_all;
using testing::one_in;
using testing::over_decades;
using testing::Worst;

namespace {

SpinPulseInput zero_23() {
  return {.ball = {}, .touchdown = {15.62, -6.71, 2.61}, .e = 0.86, .mu = 0.55, .dwell_s = 5.2e-3};
}

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

}  // namespace

TEST_GROUP(SpinPulses){};

// The rigid model knows the lift-off without going through the contact.
TEST(SpinPulses, LeaveAsTheRigidBodyDoes) {
  CHECK(holds_of_all([](Worst& worst) {
    const SpinPulseInput in = any_impact();
    const auto pulse = SpinPulse::make(in);
    const auto rigid = impact::rigid(in.ball, in.touchdown, in.e, in.mu);
    const SpinPulseState lo = pulse->at_fraction(1.0);
    // Rounding of a dozen operations on terms of at most 100 m/s.
    RC_ASSERT(worst.within(std::abs(lo.vx_mps - rigid->lift_off.vx_mps), 1e-12));
    RC_ASSERT(worst.within(std::abs(lo.vy_mps - rigid->lift_off.vy_mps), 1e-12));
    RC_ASSERT(worst.within(std::abs(lo.omega_radps - rigid->lift_off.omega_radps), 1e-10));
    RC_ASSERT(worst.within(std::abs(lo.slip_mps - rigid->slip_lo_mps), 1e-12));
  }));
}

// Friction acts in the contact line, so alpha·R·omega - vx changes by the offset's moment alone, at every
// instant; and its integral likewise.
TEST(SpinPulses, KeepTheirAngularMomentumAboutTheContactLine) {
  CHECK(holds_of_all([](Worst& worst) {
    SpinPulseInput in = any_impact();
    const double t = between(0, 1);
    in.offset_m = 1e-3 * between(-10, 10);
    const auto pulse = SpinPulse::make(in);
    const SpinPulseState s = pulse->at_fraction(t);
    const double arm = in.ball.alpha * in.ball.radius_m(), lever = in.offset_m / in.ball.radius_m();
    const double moment = arm * in.touchdown.omega_radps - in.touchdown.vx_mps;
    const double pushed = lever * (s.vy_mps - in.touchdown.vy_mps);
    RC_ASSERT(worst.within(std::abs(arm * s.omega_radps - s.vx_mps - moment - pushed), 1e-12));
    const double time_s = t * in.dwell_s;
    const double shoved = lever * (s.y_m - in.touchdown.vy_mps * time_s);
    RC_ASSERT(worst.within(std::abs(arm * s.rotation_rad - s.x_m - moment * time_s - shoved), 1e-14));
  }));
}

TEST(SpinPulses, SlipEverLessUntilTheyRollAndLoseEnergyAllTheWay) {
  CHECK(holds_of_all([](Worst& worst) {
    const SpinPulseInput in = any_impact();
    const auto pulse = SpinPulse::make(in);
    const auto energy = [&in](const SpinPulseState& s) {
      return s.vx_mps * s.vx_mps + in.ball.alpha * std::pow(in.ball.radius_m() * s.omega_radps, 2);
    };
    SpinPulseState last = pulse->at_fraction(0.0);
    for (int i = 1; i <= 50; ++i) {
      const SpinPulseState s = pulse->at_fraction(i / 50.0);
      RC_ASSERT(worst.within(std::abs(s.slip_mps) - std::abs(last.slip_mps), 1e-13));
      RC_ASSERT(s.slip_mps * last.slip_mps >= -1e-24);
      RC_ASSERT(worst.within(energy(s) - energy(last), energy(last) * 1e-14 + 1e-12));
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

// Two states an instant apart: the motion changes by its rates, of which none is above the largest force's.
TEST(SpinPulses, AreContinuousInTimeAcrossTheGripOfEveryImpact) {
  CHECK(holds_of_all([](Worst& worst) {
    SpinPulseInput in = any_impact();
    in.offset_m = 1e-3 * between(-10.0, 10.0);
    if (one_in(2)) in.form = impact::PulseForm::simplified;
    in.e = std::max(in.e, 1e-3);
    const auto pulse = SpinPulse::make(in);
    RC_PRE(pulse.has_value() && pulse->grip_fraction().has_value());
    const double apart = 1e-9, grip = *pulse->grip_fraction();
    const SpinPulseState a = pulse->at_fraction(std::max(0.0, grip - apart));
    const SpinPulseState b = pulse->at_fraction(std::min(1.0, grip + apart));
    // |vy|·pi of the normal velocity over a dwell, mu times that along the surface, 1/alpha times both to the spin.
    const double radius = in.ball.radius_m(), rates = 3.2 * std::abs(in.touchdown.vy_mps) * (2.0 + 2.0 * in.mu);
    const double allowed = 2.0 * apart * rates * (1.0 + 1.0 / in.ball.alpha) + 1e-12;
    const double speeds = std::abs(in.touchdown.vx_mps) + rates + radius * std::abs(in.touchdown.omega_radps);
    RC_ASSERT(worst.within(std::abs(a.vx_mps - b.vx_mps), allowed));
    RC_ASSERT(worst.within(radius * std::abs(a.omega_radps - b.omega_radps), allowed));
    RC_ASSERT(worst.within(std::abs(a.slip_mps - b.slip_mps), 2.0 * allowed));
    RC_ASSERT(worst.within(std::abs(a.x_m - b.x_m) / in.dwell_s, 4.0 * apart * speeds + 1e-12));
    RC_ASSERT(worst.within(radius * std::abs(a.rotation_rad - b.rotation_rad) / in.dwell_s, 4.0 * apart * speeds + 1e-12));
  }));
}

// Velocities do not know how long a contact takes, and lengths are in proportion to it: down to a nanosecond's part.
TEST(SpinPulses, OfShorterContactsAreTheSameInLessTime) {
  CHECK(holds_of_all([](Worst& worst) {
    SpinPulseInput in = any_impact();
    in.offset_m = 1e-3 * between(-10.0, 10.0);
    const double t = between(0.0, 1.0), shorter = over_decades(1e-12, 1.0);
    const auto a = SpinPulse::make(in);
    const double dwell_s = in.dwell_s;
    in.dwell_s *= shorter;
    const auto b = SpinPulse::make(in);
    const SpinPulseState p = a->at_fraction(t), q = b->at_fraction(t);
    // A few roundings of terms of at most 100 m/s, over 5 ms.
    RC_ASSERT(worst.within(std::abs(p.vx_mps - q.vx_mps), 1e-13));
    RC_ASSERT(worst.within(in.ball.radius_m() * std::abs(p.omega_radps - q.omega_radps), 1e-13));
    RC_ASSERT(worst.within(std::abs(p.x_m * shorter - q.x_m), 1e-13 * dwell_s * shorter));
    RC_ASSERT(worst.within(std::abs(p.y_m * shorter - q.y_m), 1e-13 * dwell_s * shorter));
  }));
}

// At the ends of each coefficient: what a rigid body's formulas say of them, and no way to jump there.
TEST(SpinPulses, GoOverIntoTheirLimits) {
  CHECK(holds_of_all([](Worst& worst) {
    const SpinPulseInput in = any_impact();
    const double radius = in.ball.radius_m(), t = between(0.0, 1.0), small = over_decades(1e-14, 1e-3);
    const double slip = in.touchdown.vx_mps + radius * in.touchdown.omega_radps, vy = std::abs(in.touchdown.vy_mps);
    const auto with = [&in](auto change) {
      SpinPulseInput other = in;
      change(other);
      return *SpinPulse::make(other);
    };
    // Without friction nothing but the fall changes.
    const auto smooth = with([](auto& i) { i.mu = 0.0; }).at_fraction(t);
    RC_ASSERT(smooth.vx_mps == in.touchdown.vx_mps && smooth.omega_radps == in.touchdown.omega_radps);
    // With a little of it, a little: at most mu·J.
    const auto nearly = with([small](auto& i) { i.mu = small; }).at_fraction(1.0);
    RC_ASSERT(worst.within(std::abs(nearly.vx_mps - in.touchdown.vx_mps), 2.0 * small * vy + 1e-13));
    // With any amount it rolls off: dvx = -s·alpha/(1 + alpha). The grip comes when mu·J·(1 + alpha)/alpha is the slip.
    const double mu = 1e3 * (1.0 + std::abs(slip)) / vy;
    const auto rough = with([mu](auto& i) { i.mu = mu; });
    const double rolling = in.touchdown.vx_mps - slip * in.ball.alpha / (1.0 + in.ball.alpha);
    RC_ASSERT(rough.grip_fraction().has_value() && *rough.grip_fraction() < 0.02);
    RC_ASSERT(worst.within(std::abs(rough.at_fraction(1.0).vx_mps - rolling), 1e-12));
    RC_ASSERT(worst.within(std::abs(rough.at_fraction(1.0).slip_mps), 0.0));
    // e: of 1 the fall is the mirror of the rise; of 0 it ends at rest; on the way the lift-off is e times the fall.
    const auto elastic = with([](auto& i) { i.e = 1.0; });
    RC_ASSERT(worst.within(std::abs(elastic.at_fraction(t).vy_mps + elastic.at_fraction(1.0 - t).vy_mps), 1e-13 * vy));
    RC_ASSERT(worst.within(std::abs(with([](auto& i) { i.e = 0.0; }).at_fraction(1.0).vy_mps), 1e-13 * vy));
    RC_ASSERT(worst.within(std::abs(with([small](auto& i) { i.e = small; }).at_fraction(1.0).vy_mps - small * vy),
                           1e-13 * vy));
    // An offset's moment adds at most d·J/R to alpha·R·omega, and to vx no more.
    const auto centred = with([](auto&) {}).at_fraction(1.0);
    const auto ahead = with([&](auto& i) { i.offset_m = small * radius; }).at_fraction(1.0);
    const double push = 2.0 * small * vy;
    RC_ASSERT(worst.within(std::abs(ahead.vx_mps - centred.vx_mps), push + 1e-12));
    RC_ASSERT(worst.within(radius * std::abs(ahead.omega_radps - centred.omega_radps), push / in.ball.alpha + 1e-12));
  }));
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

// The pulse carried to spin, in double precision, against quadrature of its forces in 50 digits.

namespace {

using Wide = boost::multiprecision::cpp_bin_float_50;
using Gauss = boost::math::quadrature::gauss<Wide, 30>;  // of an entire function over a phase of at most pi
const Wide kPi = boost::math::constants::pi<Wide>();

/// exp(-f·phi)·sin(phi), the force's shape; f as the restitution's root in 50 digits.
struct Shape {
  Wide f;
  Wide force(const Wide& phi) const { return exp(-f * phi) * sin(phi); }
  Wide impulse(const Wide& from, const Wide& to) const {
    return Gauss::integrate([this](const Wide& phi) { return force(phi); }, from, to);
  }
  /// What the impulse of from…to has moved by the phase `end`.
  Wide moment(const Wide& from, const Wide& to, const Wide& end) const {
    return Gauss::integrate([this, &end](const Wide& phi) { return Wide((end - phi) * force(phi)); }, from,
                            to);
  }
};

template <typename Function>
Wide root(const Function& function, const Wide& low, const Wide& high) {
  std::uintmax_t steps = 200;
  const auto bracket = boost::math::tools::toms748_solve(function, low, high,
                                                         boost::math::tools::eps_tolerance<Wide>(160), steps);
  return (bracket.first + bracket.second) / 2;
}

Wide wide_damping(double e) {
  if (e == 1.0) return 0;  // e falls from 1 to below 0 over f = 0…1/2
  return root([e](const Wide& f) { return Wide((1 + exp(-f * kPi)) / (1 + f * f) - 1 - e); }, 0, Wide(1) / 2);
}

struct WideState {
  Wide x, rotation, vx, omega, slip;
  Wide x_scale, rotation_scale, vx_scale, omega_scale;  // sums of the magnitudes of what acts
};

struct Reference {
  explicit Reference(const SpinPulseInput& input) : in(input), shape{wide_damping(input.e)} {
    radius = Wide(in.ball.diameter_m) / 2;
    alpha = in.ball.alpha;
    speed = -Wide(in.touchdown.vy_mps);
    const Wide slip = in.touchdown.vx_mps + radius * Wide(in.touchdown.omega_radps);
    slipping = slip < 0 ? -Wide(in.mu) : Wide(in.mu);
    rolling = Wide(in.offset_m) / (radius * (1 + alpha));
    if (rolling > in.mu) rolling = in.mu;
    if (rolling < -in.mu) rolling = -Wide(in.mu);
    find_grip(slip);
  }

  /// Where the slip, found by quadrature, passes through zero.
  void find_grip(const Wide& slip) {
    const auto left = [&](const Wide& phi) {
      return Wide(slip - speed * shape.impulse(0, phi) *
                             ((1 + alpha) * slipping - Wide(in.offset_m) / radius) / alpha);
    };
    grip = slip == 0 ? Wide(0) : kPi;
    if (slip == 0 || (left(kPi) > 0) == (slip > 0)) return;
    grip = root(left, 0, kPi);
  }

  WideState at(double tau) const {
    const Wide end = kPi * Wide(tau), t = Wide(tau) * Wide(in.dwell_s), length = speed * in.dwell_s / kPi;
    const Wide turn = end < grip ? end : grip;
    const Wide i_before = shape.impulse(0, turn), i_after = shape.impulse(turn, end);
    const Wide m_before = shape.moment(0, turn, end), m_after = shape.moment(turn, end, end);
    const Wide lever = Wide(in.offset_m) / radius;
    const Wide vx0 = in.touchdown.vx_mps, omega0 = in.touchdown.omega_radps;
    WideState s;
    const Wide friction = speed * (slipping * i_before + rolling * i_after);
    const Wide drag = length * (slipping * m_before + rolling * m_after);
    const Wide push = lever * speed * (i_before + i_after), shove = lever * length * (m_before + m_after);
    s.vx = vx0 - friction;
    s.x = vx0 * t - drag;
    s.omega = omega0 + (push - friction) / (alpha * radius);
    s.rotation = omega0 * t + (shove - drag) / (alpha * radius);
    s.slip = s.vx + radius * s.omega;
    s.vx_scale = abs(vx0) + abs(friction);
    s.x_scale = abs(vx0 * t) + abs(drag);
    s.omega_scale = abs(omega0) + (abs(push) + abs(friction)) / (alpha * radius);
    s.rotation_scale = abs(omega0 * t) + (abs(shove) + abs(drag)) / (alpha * radius);
    return s;
  }

  SpinPulseInput in;
  Shape shape;
  Wide radius, alpha, speed, slipping, rolling, grip;
};

double relative(double got, const Wide& want, const Wide& scale) {
  return scale == 0 ? std::abs(got) : static_cast<double>(abs(got - want) / scale);
}

double worst_error(const SpinPulse& pulse, const Reference& reference, double tau) {
  const SpinPulseState got = pulse.at_fraction(tau);
  const WideState want = reference.at(tau);
  double worst = relative(got.x_m, want.x, want.x_scale);
  worst = std::max(worst, relative(got.rotation_rad, want.rotation, want.rotation_scale));
  worst = std::max(worst, relative(got.vx_mps, want.vx, want.vx_scale));
  worst = std::max(worst, relative(got.omega_radps, want.omega, want.omega_scale));
  const Wide slip_scale = want.vx_scale + reference.radius * want.omega_scale;
  return std::max(worst, relative(got.slip_mps, want.slip, slip_scale));
}

constexpr double kTolerance = 1e-13;

void check(const Reference& reference, double tau, double& worst) {
  const SpinPulseInput& in = reference.in;
  const auto pulse = SpinPulse::make(in);
  CHECK(pulse.has_value());
  const double error = worst_error(*pulse, reference, tau);
  worst = std::max(worst, error);
  if (error < kTolerance) return;
  char where[300];
  std::snprintf(where, sizeof where,
                "vx %.17g vy %.17g omega %.17g e %.17g mu %.17g alpha %g offset %g dwell %g tau %.17g: %g",
                in.touchdown.vx_mps, in.touchdown.vy_mps, in.touchdown.omega_radps, in.e, in.mu,
                in.ball.alpha, in.offset_m, in.dwell_s, tau, error);
  FAIL(where);
}

}  // namespace

TEST_GROUP(SpinPulsePrecision){};

TEST(SpinPulsePrecision, AgreesWithFiftyDigitQuadratureAtTheEdges) {
  double worst = 0.0;
  for (const double e : {1.0, 1.0 - 1e-12, 0.86, 0.3, 0.0}) {
    for (const double mu : {0.0, 1e-9, 0.55, 10.0}) {
      for (const double omega : {-1e5, -479.87711, 0.0, 165.0}) {  // the second nearly rolls
        for (const double offset : {0.0, 0.0025, -0.03}) {
          const SpinPulseInput in{.ball = {},
                                  .touchdown = {15.62, -6.7, omega},
                                  .e = e,
                                  .mu = mu,
                                  .dwell_s = 5.2e-3,
                                  .offset_m = offset};
          const Reference reference(in);
          for (const double tau : {0.0, 1e-12, 1e-5, 0.03, 0.5, 0.97, 1.0}) check(reference, tau, worst);
        }
      }
    }
  }
}

TEST(SpinPulsePrecision, AgreesWithFiftyDigitQuadratureOverTheWholeRangeAtRandom) {
  const unsigned seed = 20261121;
  std::mt19937_64 random(seed);
  const auto uniform = [&random](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const auto decades = [&](double low, double high) {
    return std::exp(uniform(std::log(low), std::log(high)));
  };
  double worst = 0.0;
  for (int i = 0; i < 500; ++i) {
    SpinPulseInput in;
    in.ball.alpha = uniform(0.3, 2.0 / 3.0);
    const double speed = decades(1e-6, 1e3), angle = decades(1e-4, 1.5);
    in.touchdown = {speed * std::cos(angle), -speed * std::sin(angle), 0.0};
    // Half of the spins within a factor of rolling, half anywhere.
    in.touchdown.omega_radps = i % 2 == 0 ? uniform(-2.0, 2.0) * in.touchdown.vx_mps / in.ball.radius_m()
                                          : (i % 4 == 1 ? -1.0 : 1.0) * decades(1e-3, 1e5);
    in.e = i % 5 == 0 ? 1.0 - decades(1e-15, 0.1) : uniform(0.0, 1.0);
    in.mu = i % 3 == 0 ? decades(1e-6, 10.0) : uniform(0.0, 1.0);
    in.dwell_s = decades(1e-6, 1.0);
    in.offset_m = i % 4 == 0 ? 0.0 : uniform(-0.03, 0.03);
    check(Reference(in), i % 2 == 0 ? uniform(0.0, 1.0) : decades(1e-9, 1.0), worst);
  }
  std::printf("spin pulse: worst error %.2g, seed %u\n", worst, seed);
}
