// The contact by return mapping, against the mechanics at a tolerance of 1e-9.
#include "common/impact/ode/return_mapping.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/common/contact_ode/drawn_contacts.hpp"
#include "tests/support/allocations.hpp"
#include "tests/support/repetitions.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::testing;
using impact::Motion;
using impact::return_mapping;

namespace {

/// 1 to 60 m/s, 5 to 85 degrees, spins up to rolling, balls and surfaces of the court.
ContactCase practical(ContactDraws& draws) {
  ContactCase c;
  const double speed = draws.over_decades(1.0, 60.0),
               angle = draws.between(5.0, 85.0) * std::numbers::pi / 180.0;
  c.touchdown = {speed * std::cos(angle), -speed * std::sin(angle),
                 draws.between(-1.0, 1.0) * speed / contact_ball().radius_m()};
  c.coefficients.e = draws.between(0.5, 0.9);
  c.coefficients.mu = draws.between(0.3, 0.9);
  c.coefficients.dwell_s = draws.between(3e-3, 6.5e-3);
  c.coefficients.stiffness_ratio = draws.over_decades(0.7, 2.5);
  c.coefficients.damping_ratio = draws.over_decades(0.2, 1.5);
  c.coefficients.offset_share = draws.between(0.0, 0.25);
  return c;
}

double apart(const ContactCase& c, const Motion& a, const Motion& b) {
  const double spin = contact_ball().radius_m() * (a.omega_radps - b.omega_radps);
  return std::hypot(a.vx_mps - b.vx_mps, a.vy_mps - b.vy_mps, spin) /
         std::hypot(c.touchdown.vx_mps, c.touchdown.vy_mps);
}

struct Errors {
  double worst = 0.0, square = 0.0;
};

Errors errors_with(int steps, double gravity_mps2, double along_mps2 = 0.0) {
  ContactDraws draws(5);
  Errors errors;
  const int count = repetitions(400);
  for (int i = 0; i < count; ++i) {
    ContactCase c = practical(draws);
    c.coefficients.gravity_mps2 = gravity_mps2;
    c.coefficients.gravity_along_mps2 = along_mps2;
    const auto exact = impact::simulate(contact_ball(), c.touchdown, c.coefficients, {.tolerance = 1e-9});
    const auto quick = return_mapping(contact_ball(), c.touchdown, c.coefficients, steps);
    const double error = apart(c, quick->lift_off, exact->lift_off);
    errors.worst = std::max(errors.worst, error);
    errors.square += error * error / count;
  }
  return errors;
}

}  // namespace

TEST_GROUP(ReturnMapping){};

// The worst of 2,000 such draws are a third below these.
TEST(ReturnMapping, ErrsByNoMoreThanItsHeaderSays) {
  CHECK(errors_with(8, 0.0).worst < 0.04);
  CHECK(errors_with(16, 0.0).worst < 0.01);
  CHECK(errors_with(64, 0.0).worst < 7e-4);
  CHECK(errors_with(64, 8.5, 4.9).worst < 7e-4);
}

// Second order but for the step in which the mode changes, whose length and limit are of first order each: with four
// times the steps rms errors are at most an eighth.
TEST(ReturnMapping, ErrorsFallNearlyAsTheSquareOfTheStep) {
  for (const int steps : {16, 64, 256})
    CHECK(errors_with(4 * steps, 0.0).square < errors_with(steps, 0.0).square / 64.0);
}

TEST(ReturnMapping, AMirroredContactIsTheMirrorImageToTheLastBit) {
  ContactDraws draws(6);
  for (int i = 0; i < 300; ++i) {
    const ContactCase c = draw_contact(draws);
    const Motion left{-c.touchdown.vx_mps, c.touchdown.vy_mps, -c.touchdown.omega_radps};
    impact::ContactCoefficients mirrored = c.coefficients;
    mirrored.gravity_along_mps2 = -mirrored.gravity_along_mps2;
    const auto a = return_mapping(contact_ball(), c.touchdown, c.coefficients, 8);
    const auto b = return_mapping(contact_ball(), left, mirrored, 8);
    DOUBLES_EQUAL(a->lift_off.vx_mps, -b->lift_off.vx_mps, 0.0);
    DOUBLES_EQUAL(a->lift_off.vy_mps, b->lift_off.vy_mps, 0.0);
    DOUBLES_EQUAL(a->lift_off.omega_radps, -b->lift_off.omega_radps, 0.0);
  }
}

// All impulses of a slide are in closed form: roundings of 8 steps.
TEST(ReturnMapping, SlidingWithoutAnOffsetIsExact) {
  impact::ContactCoefficients c;
  c.mu = 0.1;
  c.offset_share = 0.0;
  const Motion td{15.0, -5.0, 20.0};
  const auto rebound = return_mapping(contact_ball(), td, c, 8);
  const double impulse = (1.0 + c.e) * 5.0, alpha = contact_ball().alpha, radius = contact_ball().radius_m();
  DOUBLES_EQUAL(15.0 - 0.1 * impulse, rebound->lift_off.vx_mps, 15.0 * 1e-14);
  DOUBLES_EQUAL(20.0 - 0.1 * impulse / (alpha * radius), rebound->lift_off.omega_radps, 100.0 * 1e-14);
  DOUBLES_EQUAL(5.0 * c.e, rebound->lift_off.vy_mps, 5.0 * 1e-14);
  DOUBLES_EQUAL(0.1, rebound->impulse_ratio, 1e-14);
  CHECK(Regime::slides == rebound->regime);
}

// Friction's impulse is at most mu times the normal one, whatever the springs.
TEST(ReturnMapping, OverTheWholeRangeFrictionKeepsItsLimit) {
  ContactDraws draws(7);
  for (int i = 0; i < repetitions(5000); ++i) {
    ContactCase c = draw_contact(draws);
    c.coefficients.stiffness_ratio = draws.over_decades(1e-3, 1e3);
    c.coefficients.damping_ratio = draws.one_in(4) ? 0.0 : draws.over_decades(0.01, 10.0);
    const auto rebound = return_mapping(contact_ball(), c.touchdown, c.coefficients, 4);
    CHECK(rebound.has_value());
    CHECK(std::isfinite(rebound->lift_off.omega_radps));
    CHECK(std::abs(rebound->impulse_ratio) <= c.coefficients.mu * (1.0 + 1e-12));
    CHECK(std::abs(rebound->offset_m) <=
          c.coefficients.offset_share * contact_ball().radius_m() * (1.0 + 1e-12));
  }
}

TEST(ReturnMapping, RefusesWhatTheMechanicsRefuse) {
  const auto error = [](const Motion& td, const impact::ContactCoefficients& c, int steps) {
    return return_mapping(contact_ball(), td, c, steps).error();
  };
  CHECK(impact::InputError::not_approaching == error({1.0, 1.0, 0.0}, {}, 8));
  CHECK(impact::InputError::restitution_out_of_range == error({1.0, -1.0, 0.0}, {.e = 1.5}, 8));
  CHECK(impact::InputError::tolerance_out_of_range == error({1.0, -1.0, 0.0}, {}, 1));
  CHECK(impact::InputError::no_release == error({1.0, -0.01, 0.0}, {.gravity_mps2 = 100.0}, 8));
}

TEST(ReturnMapping, AllocatesNothing) {
  const AllocationCounter counter;
  const auto rebound = return_mapping(contact_ball(), {15.0, -5.0, 20.0}, {}, 8);
  LONGS_EQUAL(0, counter.count());
  CHECK(rebound.has_value());
}
