// What holds of every contact: energy never grows, a mirrored contact is the mirror image, other units give the same
// contact, every contact of the stated range is computed. Failing cases print the configuration that repeats them.
#include <cmath>
#include <numbers>
#include <rapidcheck.h>
#include <vector>

#include "common/impact/ode/contact_trajectory.hpp"
#include "tests/common/contact_ode/drawn_contacts.hpp"
#include "tests/support/property.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::impact;
using strobe::testing::between;
using strobe::testing::holds_of_all;
using strobe::testing::one_in;
using strobe::testing::over_decades;
using strobe::testing::sometimes;
using strobe::testing::Worst;

namespace {

const ball::Ball kPropertiesBall{.alpha = 0.579};

ContactMethod any_accurate_method() {
  return *rc::gen::element(ContactMethod::collocation, ContactMethod::dormand_prince);
}

Motion any_touchdown() {
  const double degree = std::numbers::pi / 180.0, speed = over_decades(1e-6, 1e3);
  const double angle = *rc::gen::arbitrary<bool>() ? over_decades(0.01, 90.0) : between(1.0, 90.0);
  const double side = *rc::gen::arbitrary<bool>() ? 1.0 : -1.0;
  Motion m{side * speed * std::cos(angle * degree), -speed * std::sin(angle * degree), 0.0};
  switch (static_cast<int>(between(0.0, 3.999))) {
    case 0:
      break;
    case 1:  // rolling, to the last bit or nearly
      m.omega_radps = -m.vx_mps / kPropertiesBall.radius_m();
      break;
    case 2:
      m.omega_radps = between(-3.0, 3.0) * speed / kPropertiesBall.radius_m();
      break;
    default:
      m.omega_radps = between(-1e5, 1e5);
  }
  m.omega_radps = std::clamp(m.omega_radps, -1e5, 1e5);
  return m;
}

/// From nothing to much of everything, with the exact zeros and ones at which laws change.
ContactCoefficients any_coefficients() {
  ContactCoefficients c;
  c.e = sometimes(1.0, between(0.05, 1.0));
  c.dwell_s = over_decades(1e-6, 1.0);
  c.mu = sometimes(0.0, over_decades(1e-3, 10.0));
  c.stiffness_ratio = over_decades(0.05, 20.0);
  c.damping_ratio = sometimes(0.0, over_decades(0.05, 5.0));
  c.offset_share = sometimes(0.0, between(0.0, 1.0));
  c.offset_reference_mps = over_decades(1e-3, 1e3);
  c.gravity_along_mps2 = sometimes(9.8, 0.0) * between(-1.0, 1.0);
  return c;
}

}  // namespace

TEST_GROUP(ContactProperties){};

// Between any two of the asked times the energy may differ by what the integration's
// tolerance and the rounding of the energies themselves allow, and no more. Losses only grow.
TEST(ContactProperties, EnergyNeverGrows) {
  CHECK(holds_of_all([](Worst& worst) {
    const Motion touchdown = any_touchdown();
    const ContactCoefficients c = any_coefficients();
    const auto contact = ContactTrajectory::make(kPropertiesBall, touchdown, c,
                                                 {.method = any_accurate_method(), .tolerance = 1e-9});
    RC_ASSERT(contact.has_value());
    const double normal = 0.5 * kPropertiesBall.mass_kg * touchdown.vy_mps * touchdown.vy_mps;
    const ContactEnergy& energy = contact->summary().energy;
    // Tangential errors weigh with the speeds that they change.
    const double turning = std::abs(kPropertiesBall.radius_m() * touchdown.omega_radps);
    const double pulled = std::abs(c.gravity_along_mps2) * contact->summary().dwell_s;
    const double moving = std::abs(touchdown.vx_mps) + turning - touchdown.vy_mps + pulled;
    const double allowed =
        1e-9 * kPropertiesBall.mass_kg * (pulled - touchdown.vy_mps) * moving * (1.0 + c.mu) + 1e-9 * normal +
        8e-16 * energy.kinetic_td_j;
    ContactState before = contact->at(0.0);
    for (int i = 0; i <= 200; ++i) {
      const ContactState now = contact->at(contact->summary().dwell_s * i / 200.0);
      RC_ASSERT(worst.within(now.mechanical_energy_j - before.mechanical_energy_j, allowed));
      RC_ASSERT(worst.within(before.dissipated_j - now.dissipated_j, allowed));
      before = now;
    }
    // Collocation's sums over its nodes are good to 5e-8 (contact_ode.hpp): of 75,000 drawn one was wrong by 3.3e-8, a slip
    // whose stretch decays by nearly all that a segment may.
    const double sums = contact->summary().method == ContactMethod::collocation ? 50.0 : 1.0;
    RC_ASSERT(worst.within(std::abs(energy.kinetic_lost_j - energy.dissipated_j()), sums * allowed));
  }));
}

TEST(ContactProperties, AMirroredContactIsTheMirrorImageToTheLastBit) {
  CHECK(holds_of_all([] {
    const Motion touchdown = any_touchdown();
    const ContactCoefficients c = any_coefficients();
    ContactCoefficients mirrored = c;
    mirrored.gravity_along_mps2 *= -1.0;
    const ContactOptions options{.method = any_accurate_method()};
    const auto one = simulate(kPropertiesBall, touchdown, c, options);
    const auto other = simulate(
        kPropertiesBall, {-touchdown.vx_mps, touchdown.vy_mps, -touchdown.omega_radps}, mirrored, options);
    RC_ASSERT(one.has_value() && other.has_value());
    RC_ASSERT(one->lift_off.vx_mps == -other->lift_off.vx_mps);
    RC_ASSERT(one->lift_off.vy_mps == other->lift_off.vy_mps);
    RC_ASSERT(one->lift_off.omega_radps == -other->lift_off.omega_radps);
    RC_ASSERT(one->dwell_distance_m == -other->dwell_distance_m);
    RC_ASSERT(one->mean_offset_m == -other->mean_offset_m);
    RC_ASSERT(one->event_count == other->event_count);
    RC_ASSERT(one->energy.sliding_j == other->energy.sliding_j);
  }));
}

TEST(ContactProperties, EveryContactEndsAfterItsDwellTimeWithFewSteps) {
  CHECK(holds_of_all([](Worst& worst) {
    const Motion touchdown = any_touchdown();
    ContactCoefficients c = any_coefficients();
    // Far below |vy| the offset is dry friction, as stiff as it is dry.
    c.offset_reference_mps = std::max(c.offset_reference_mps, 1.0);
    const auto s =
        simulate(kPropertiesBall, touchdown, c, {.method = any_accurate_method(), .tolerance = 1e-9});
    RC_ASSERT(s.has_value());
    RC_ASSERT(worst.within(std::abs(s->dwell_s / c.dwell_s - 1.0), 1e-8));
    RC_ASSERT(worst.within(std::abs(s->lift_off.vy_mps / (-c.e * touchdown.vy_mps) - 1.0), 1e-9 / c.e));
    RC_ASSERT(s->steps < 5000);
    // Where rounding cannot tell grip from slip a step of 1e-7 of the contact holds what no friction could. Collocation takes
    // the weight's fall in closed form; of 25,000 drawn the integrator's steps lost up to 4e-8 of a long one.
    const double fall = c.gravity_along_mps2 * s->dwell_s / (s->lift_off.vy_mps - touchdown.vy_mps);
    const double lost = s->method == ContactMethod::collocation ? 1e-14 : 2e-7;
    RC_ASSERT(std::abs(s->impulse_ratio + fall) <= c.mu * (1.0 + 1e-8) + 1e-7 + lost * std::abs(fall));
  }));
}

// A unit that is a power of two times another changes exponents only.
TEST(ContactProperties, OtherUnitsOfTimeAndLengthGiveTheSameContactToTheLastBit) {
  CHECK(holds_of_all([] {
    const Motion touchdown = any_touchdown();
    const ContactCoefficients c = any_coefficients();
    const int time_power = *rc::gen::inRange(-8, 9), length_power = *rc::gen::inRange(-8, 9);
    const auto speed = [&](double v) { return std::ldexp(v, length_power - time_power); };
    const auto acceleration = [&](double a) { return std::ldexp(a, length_power - 2 * time_power); };
    RC_PRE(std::abs(acceleration(c.gravity_along_mps2)) <= 1e3);
    ContactCoefficients other = c;
    other.dwell_s = std::ldexp(c.dwell_s, time_power);
    other.offset_reference_mps = speed(c.offset_reference_mps);
    other.gravity_along_mps2 = acceleration(c.gravity_along_mps2);
    ball::Ball ball = kPropertiesBall;
    ball.diameter_m = std::ldexp(ball.diameter_m, length_power);
    const ContactOptions options{.method = any_accurate_method()};
    const auto a = simulate(kPropertiesBall, touchdown, c, options);
    const auto b = simulate(ball,
                            {speed(touchdown.vx_mps), speed(touchdown.vy_mps),
                             std::ldexp(touchdown.omega_radps, -time_power)},
                            other, options);
    RC_ASSERT(a.has_value() && b.has_value());
    RC_ASSERT(b->lift_off.vx_mps == speed(a->lift_off.vx_mps));
    RC_ASSERT(b->lift_off.vy_mps == speed(a->lift_off.vy_mps));
    RC_ASSERT(b->lift_off.omega_radps == std::ldexp(a->lift_off.omega_radps, -time_power));
    RC_ASSERT(b->dwell_s == std::ldexp(a->dwell_s, time_power));
    RC_ASSERT(b->dwell_distance_m == std::ldexp(a->dwell_distance_m, length_power));
    RC_ASSERT(b->rotation_rad == a->rotation_rad);
    RC_ASSERT(b->event_count == a->event_count);
  }));
}

// Friction passes through the contact point: the offset's moment and the weight alone turn the ball about it. Both
// sides are sums of the motion's changes, each good to the tolerance of its scale.
TEST(ContactProperties, AngularMomentumAboutTheContactPointIsTheOffsetsAndTheWeights) {
  CHECK(holds_of_all([](Worst& worst) {
    const testing::ContactCase x{any_touchdown(), any_coefficients()};
    const auto s = simulate(testing::contact_ball(), x.touchdown, x.coefficients,
                            {.method = any_accurate_method(), .tolerance = 1e-9});
    RC_ASSERT(s.has_value());
    const double radius = testing::contact_ball().radius_m();
    const double turned = testing::contact_ball().alpha * radius * (s->lift_off.omega_radps - x.touchdown.omega_radps);
    const double fallen = x.coefficients.gravity_along_mps2 * s->dwell_s;
    const double couple = s->mean_offset_m / radius * (s->lift_off.vy_mps - x.touchdown.vy_mps);
    RC_ASSERT(worst.within(std::abs(turned - (s->lift_off.vx_mps - x.touchdown.vx_mps - fallen) - couple),
                           3e-9 * testing::tangential_scale(x) + testing::rounding_of(x)));
  }));
}

namespace {

/// An end of the range one time in five, else evenly in the logarithm.
double end_or_within(double low, double high) { return sometimes(low, sometimes(high, over_decades(low, high), 9), 10); }

struct AnyContact {
  ball::Ball ball;
  Motion touchdown;
  ContactCoefficients coefficients;
  ContactOptions options;
};

/// Over all of what contact_ode.hpp says is computed: touchdowns of practice, or up to the ends of what is not refused.
AnyContact any_contact_of_the_range() {
  AnyContact x;
  ContactCoefficients& c = x.coefficients;
  const bool practical = one_in(2);
  x.ball.alpha = end_or_within(0.01, ball::kThinShellAlpha);
  x.ball.diameter_m = practical ? ball::kThesisDiameter_m : end_or_within(1e-9, 1e9);
  const double vy = practical ? over_decades(0.1, 60.0) : end_or_within(1e-15, 1e9), radius = x.ball.radius_m();
  const auto signed_speed = [&] {
    const double most = std::min(1e9, 0.999e15 * vy);
    const double speed = practical ? between(0.0, 60.0) : std::min(most, vy * end_or_within(1e-6, 1e15));
    return one_in(2) ? speed : -speed;
  };
  x.touchdown = {sometimes(0.0, signed_speed()), -vy, 0.0};
  const double spin = sometimes(0.0, sometimes(-x.touchdown.vx_mps, signed_speed(), 4));
  x.touchdown.omega_radps = std::clamp(spin / radius, -1e9, 1e9);
  c.e = end_or_within(1e-3, 1.0);
  c.dwell_s = practical ? over_decades(1e-4, 0.1) : end_or_within(1e-9, 1e3);
  c.mu = sometimes(0.0, end_or_within(1e-6, 1e3));
  c.stiffness_ratio = end_or_within(1e-3, 1e3);
  c.damping_ratio = sometimes(0.0, end_or_within(0.01, 10.0));
  c.offset_share = sometimes(0.0, sometimes(1.0, between(0.0, 1.0)), 3);
  c.offset_reference_mps = std::clamp(vy * end_or_within(1e-4, 1e4), std::max(1e-9, 1e-4 * vy), 1e9);
  if (one_in(3)) c.gravity_along_mps2 = std::clamp(vy / c.dwell_s * between(-100.0, 100.0), -1e3, 1e3);
  x.options = {any_accurate_method(), std::clamp(end_or_within(1e-12, 1e-3), 1e-12, 1e-3)};
  return x;
}

}  // namespace

// A gain: of what there is at the start and what the weight does, within the tolerance. Its last bits: the energies are
// sums of squares of the speeds.
TEST(ContactProperties, EveryContactOfTheStatedRangeIsComputedWithoutEnergyFromNowhere) {
  CHECK(holds_of_all([](Worst& worst) {
    const AnyContact x = any_contact_of_the_range();
    const auto s = simulate(x.ball, x.touchdown, x.coefficients, x.options);
    RC_ASSERT(s.has_value());
    for (const double value : {s->lift_off.vx_mps, s->lift_off.vy_mps, s->lift_off.omega_radps, s->dwell_s,
                               s->dwell_distance_m, s->rotation_rad, s->max_friction_n, s->max_force_n,
                               s->energy.dissipated_j()})
      RC_ASSERT(std::isfinite(value));
    const ContactEnergy& e = s->energy;
    const double there = e.kinetic_td_j + std::abs(e.gravity_work_j);
    RC_ASSERT(worst.within(-(e.kinetic_lost_j + e.gravity_work_j), (x.options.tolerance + 1e-14) * there));
    RC_ASSERT(s->event_list().back().kind == ContactEventKind::release);
  }));
}

// Beside the same contact to 1e-12. Of 80,000 drawn, half by each method, collocation passed its tolerance in 2, to 2.7
// times it, the integrator in 12, to 8 times: its steps keep theirs, and what follows may amplify their errors (a spin that passes
// through 0 under an offset, a slip that sets in with a light touch). Hence the hard bound of 30, and one in 500.
TEST(ContactProperties, TheToleranceAskedForIsKeptButForOneInFiveHundred) {
  int draws = 0, beyond = 0;
  CHECK(holds_of_all([&](Worst& worst) {
    testing::ContactCase x{any_touchdown(), any_coefficients()};
    ContactCoefficients& c = x.coefficients;
    c.offset_reference_mps = std::max(c.offset_reference_mps, -1e-4 * x.touchdown.vy_mps);
    const double tolerance = over_decades(1e-11, 1e-3), radius = testing::contact_ball().radius_m();
    const auto got =
        lift_off(testing::contact_ball(), x.touchdown, c, {.method = any_accurate_method(), .tolerance = tolerance});
    const auto exact = lift_off(testing::contact_ball(), x.touchdown, c,
                                {.method = ContactMethod::dormand_prince, .tolerance = 1e-12});
    RC_ASSERT(got.has_value() && exact.has_value());
    const double scale = testing::tangential_scale(x) + testing::rounding_of(x) / tolerance;
    const double error =
        std::max({std::abs(got->lift_off.vx_mps - exact->lift_off.vx_mps) / scale,
                  radius * std::abs(got->lift_off.omega_radps - exact->lift_off.omega_radps) / scale,
                  std::abs(got->lift_off.vy_mps - exact->lift_off.vy_mps) / -x.touchdown.vy_mps,
                  std::abs(got->dwell_s / exact->dwell_s - 1.0)});
    RC_ASSERT(worst.within(error / (tolerance + 1e-12), 30.0));
    beyond += error > tolerance + 1e-12;
    ++draws;
  }));
  CHECK(beyond <= 2 + draws / 500);
}

// The lift-off is continuously differentiable, across every change of regime too: a change of 1e-9 of one input moves it
// by that times a slope. Slopes are at most some 1e4, of springs that swing to and fro and of spins that an offset turns
// round within w0 of 0; a jump, of a grip that comes or goes, would be of the speeds themselves.
TEST(ContactProperties, TheLiftOffIsContinuousInEveryInput) {
  CHECK(holds_of_all([](Worst& worst) {
    const Motion m = any_touchdown();
    ContactCoefficients c = any_coefficients();
    c.offset_reference_mps = std::max(c.offset_reference_mps, -1e-2 * m.vy_mps);
    const double radius = kPropertiesBall.radius_m();
    const double speeds = std::abs(m.vx_mps) - m.vy_mps + radius * std::abs(m.omega_radps) +
                          std::abs(c.gravity_along_mps2) * c.dwell_s;
    Motion near = m;
    ContactCoefficients other = c;
    ball::Ball ball = kPropertiesBall;
    const std::vector<double*> inputs{&near.vx_mps,        &near.vy_mps,           &near.omega_radps,
                                      &ball.alpha,         &ball.diameter_m,       &other.e,
                                      &other.mu,           &other.stiffness_ratio, &other.damping_ratio,
                                      &other.offset_share, &other.dwell_s,         &other.offset_reference_mps,
                                      &other.gravity_along_mps2};
    *inputs[static_cast<std::size_t>(between(0.0, 12.999))] *= 1.0 - 1e-9;
    const ContactOptions options{.method = any_accurate_method(), .tolerance = 1e-11};
    const auto a = lift_off(kPropertiesBall, m, c, options), b = lift_off(ball, near, other, options);
    RC_ASSERT(a.has_value() && b.has_value());
    const double moved = std::max({std::abs(a->lift_off.vx_mps - b->lift_off.vx_mps),
                                   std::abs(a->lift_off.vy_mps - b->lift_off.vy_mps),
                                   radius * std::abs(a->lift_off.omega_radps - b->lift_off.omega_radps)});
    RC_ASSERT(worst.within(moved, 1e-5 * speeds));
  }));
}
